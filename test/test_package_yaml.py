"""Reading YAML of people: plain data or one line that says file, line and fault."""

import pytest

from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError


def read(tmp_path, text):
    path = tmp_path / "file.yaml"
    path.write_text(text, encoding="utf-8")
    return read_yaml(path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5e-3", 0.005), ("1.5", 1.5), (".5", 0.5), ("3.", 3.0), ("-3", -3), ("+4", 4),
        ("0", 0), ("010", 10.0),
        ("true", True), ("False", False), ("null", None), ("~", None), ("", None),
        ("yes", "yes"), ("on", "on"), ("1:30", "1:30"), ("0x10", "0x10"), ("2020-01-01", "2020-01-01"),
        ("'3'", "3"), ("1.2.3", "1.2.3"), ("Ω", "Ω"),
    ],
)  # fmt: skip
def test_scalars_are_read_as_a_person_means_them(tmp_path, text, value):
    read_value = read(tmp_path, f"a: {text}")["a"]
    assert read_value == value
    assert type(read_value) is type(value)


def test_numbers_that_are_none_are_still_read(tmp_path):
    content = read(tmp_path, "a: .inf\nb: -.inf\nc: .nan")
    assert [str(value) for value in content.values()] == ["inf", "-inf", "nan"]


def test_an_empty_file_is_nothing(tmp_path):
    assert read(tmp_path, "") is None
    assert read(tmp_path, "# only a comment\n") is None


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a: 1\na: 2", ":2: 'a' is given twice"),
        ("a: &x 1\nb: *x", ":2: aliases are not allowed"),
        ("a:\n  !!python/object/apply:os.system [ls]", ":2: tags are not allowed"),
        ("a: !!binary aGk=", ":1: tags are not allowed"),
        ("? [1, 2]\n: 3", ":1: a name must be a plain text"),
        ("a: [1", "not valid YAML"),
        ("\t- x", "not valid YAML"),
        ("a: 1\n---\nb: 2", "another document"),
        ("a: \x00", "not valid YAML"),
        ("[" * 5000, "nested too deeply"),
        ("a" * 1_000_001, "larger than"),
    ],
)
def test_faults_are_told_in_one_line_with_the_place(tmp_path, text, fault):
    with pytest.raises(ConfigurationError) as error:
        read(tmp_path, text)
    assert str(error.value).startswith(str(tmp_path / "file.yaml"))
    assert fault in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_none_is_told(tmp_path):
    (tmp_path / "latin.yaml").write_bytes(b"a: \xff")
    for path, fault in (
        (tmp_path / "missing.yaml", "no such file"),
        (tmp_path, "not a file"),
        ("/dev/zero", "not a file"),
        (tmp_path / "latin.yaml", "not UTF-8"),
    ):
        with pytest.raises(ConfigurationError, match=fault):
            read_yaml(path)
