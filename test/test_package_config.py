"""config/follower.yaml repeats the dataclasses; parameter files are laid over one another and checked."""

import re
from pathlib import Path

import pytest
import rclpy

from follower_humanoid.core.config import ParameterInfo
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.graph import config_writer
from follower_humanoid.graph.config_file import load_parameters
from follower_humanoid.graph.node_configs import node_names, node_parameters, shared_parameters

CONFIG = Path(__file__).resolve().parent.parent / "config" / "follower.yaml"
REWRITE = "run: python -m follower_humanoid.graph.config_writer config/follower.yaml"


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def load(tmp_path):
    """Loads texts as files laid over one another."""

    def load_texts(*texts: str, namespace: str = ""):
        files = [write(tmp_path / f"{i}.yaml", text) for i, text in enumerate(texts)]
        return load_parameters(files, namespace)

    return load_texts


def fault_of(load, *texts: str) -> str:
    with pytest.raises(ConfigurationError) as error:
        load(*texts)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("node", node_names())
def test_every_parameter_stands_in_the_file_with_its_default(node):
    loaded = load_parameters([CONFIG]).get(node, {})
    assert loaded == {name: info.default for name, info in node_parameters(node).items()}, REWRITE


def test_the_file_is_the_generated_one():
    assert CONFIG.read_text(encoding="utf-8") == config_writer.config_text(), REWRITE


def test_shared_parameters_stand_in_one_block_and_nowhere_else():
    blocks = {key: set(block["ros__parameters"]) for key, block in read_yaml(CONFIG).items()}
    assert blocks.pop("/**") == set(shared_parameters())
    for names in blocks.values():
        assert not names & set(shared_parameters())


def test_every_line_has_a_meaning_and_every_number_a_unit():
    lines = [line for line in CONFIG.read_text(encoding="utf-8").splitlines() if line.startswith("    ")]
    assert len(lines) > 100
    for line in lines:
        assert re.search(r"  # \S", line), line
        value = line.split(": ", 1)[1]
        if re.match(r"[\[\d+.-]", value):
            assert re.search(r"  # \[\S+\] \S", line), line


def test_ros_itself_reads_the_file_with_the_same_types_and_values():
    # ROS 2 takes `1` for an integer and `1.0` for a double: a double written without its point is refused.
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(CONFIG)], context=context)
    try:
        for name in node_names():
            node = rclpy.create_node(
                name, context=context, automatically_declare_parameters_from_overrides=True
            )
            for info in node_parameters(name).values():
                value = node.get_parameter(info.name).value
                value = tuple(value) if isinstance(info.default, tuple) else value
                assert value == info.default, f"{name}: {info.name}"
                assert type(value) is type(info.default), f"{name}: {info.name}"
            node.destroy_node()
    finally:
        context.shutdown()


def test_later_files_win_and_the_rest_stays(load):
    first = "gait_mapping:\n  ros__parameters: {start_force: 1.0, stop_force: 0.5}"
    second = "gait_mapping:\n  ros__parameters: {start_force: 2}"
    assert load(first, second) == {"gait_mapping": {"start_force": 2.0, "stop_force": 0.5}}


def test_nested_mappings_and_dotted_names_are_the_same(load):
    nested = load("simulator:\n  ros__parameters:\n    motors: {gear: 60}")
    assert nested == load("simulator:\n  ros__parameters: {motors.gear: 60.0}")


def test_a_pattern_reaches_every_node_that_has_the_parameter(load):
    loaded = load("/**:\n  ros__parameters: {tick: 0.004}")
    assert loaded == {node: {"tick": 0.004} for node in node_names()}
    assert set(load("/**:\n  ros__parameters: {motor.gear: 60.0}")) == {"leg_controller", "arm_controller"}


def test_an_exact_name_wins_over_a_pattern_wherever_it_stands(load):
    loaded = load("simulator: {ros__parameters: {tick: 0.001}}\n/**: {ros__parameters: {tick: 0.004}}")
    assert loaded["simulator"]["tick"] == 0.001
    assert loaded["leader"]["tick"] == 0.004


@pytest.mark.parametrize(
    ("key", "namespace", "found"),
    [
        ("simulator", "", True),
        ("simulator", "robot", True),
        ("/simulator", "", True),
        ("/simulator", "robot", False),
        ("/robot/simulator", "robot", True),
        ("/robot/simulator", "", False),
        ("robot/simulator", "/robot", True),
        ("/**/simulator", "a/b", True),
        ("/*/simulator", "robot", True),
        ("/*/simulator", "a/b", False),
        ("/*/simulator", "", False),
    ],
)
def test_names_and_namespaces(load, key, namespace, found):
    text = f"{key}: {{ros__parameters: {{realtime: true}}}}"
    if found:
        assert load(text, namespace=namespace) == {"simulator": {"realtime": True}}
    else:
        with pytest.raises(ConfigurationError, match="no node"):
            load(text, namespace=namespace)


def test_namespaces_may_be_nested(load):
    text = "robot:\n  simulator:\n    ros__parameters: {realtime: true}"
    assert load(text, namespace="robot") == {"simulator": {"realtime": True}}


def test_empty_files_and_blocks_set_nothing(load):
    assert load("", "# nothing", "simulator:\n  ros__parameters:\n") == {}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("simulater: {ros__parameters: {realtime: true}}", ["no node", "'simulater'", "simulator"]),
        ("simulator: {ros__parameters: {real: true}}", ["simulator", "'real'", "realtime"]),
        ("/**: {ros__parameters: {no_such: 1}}", ["'no_such'", "motor.gear"]),
        ("simulator: {ros__parameters: {realtime: 1}}", ["simulator", "realtime = 1", "true or false"]),
        ("simulator: {ros__parameters: {soles.stiffness: .nan}}", ["soles.stiffness = nan", "finite"]),
        ("simulator: {ros__parameters: {soles.stiffness: .inf}}", ["soles.stiffness = inf", "finite"]),
        ("simulator: {ros__parameters: {soles.stiffness: -1.0}}", ["soles.stiffness = -1", "1000.0 to"]),
        ("simulator: {ros__parameters: {soles.stiffness: stiff}}", ["soles.stiffness = 'stiff'", "number"]),
        ("simulator: {ros__parameters: {soles.stiffness: }}", ["soles.stiffness = None", "number"]),
        (f"simulator: {{ros__parameters: {{soles.stiffness: {'9' * 400}}}}}", ["soles.stiffness"]),
        ("simulator: {ros__parameters: {sensors.seed: 1.5}}", ["sensors.seed = 1.5", "whole number"]),
        ("simulator: {ros__parameters: {sensors.gyro_bias: [0, 0]}}", ["sensors.gyro_bias", "needs 3"]),
        ("simulator: {ros__parameters: {sensors.gyro_bias: 0.0}}", ["sensors.gyro_bias", "needs 3"]),
        ("zmp_balance: {ros__parameters: {law: magic}}", ["law = 'magic'", "dcm"]),
        ("leader: {ros__parameters: {programme: 3}}", ["programme = 3", "text"]),
        ("leader: {ros__parameters: {a.b: 1, a: {b: 2}}}", ["leader", "a.b is given twice"]),
        ("leader:\n  programme: fig4", ["leader", "ros__parameters"]),
        ("leader: fig4", ["leader", "ros__parameters"]),
        ("leader: {}", ["leader", "ros__parameters"]),
        ("leader: {ros__parameters: 3}", ["leader", "ros__parameters"]),
        ("leader: {ros__parameters: {}, programme: fig4}", ["programme", "beside"]),
        ("- leader", ["ros__parameters"]),
        ("leader: {ros__parameters: {programme: fig4}", ["not valid YAML"]),
    ],
)
def test_faults_name_file_node_parameter_value_and_what_is_valid(load, tmp_path, text, told):
    fault = fault_of(load, "", text)
    for word in (str(tmp_path / "1.yaml"), *told):
        assert word in fault


def test_values_that_only_together_are_wrong_are_found_across_files(load, tmp_path):
    first = "gait_mapping: {ros__parameters: {start_force: 1.0}}"
    fault = fault_of(load, first, "gait_mapping: {ros__parameters: {stop_force: 3.0}}")
    assert "gait_mapping" in fault
    assert str(tmp_path / "1.yaml") in fault


def test_a_new_float_is_written_with_its_point():
    info = ParameterInfo("name", 1e-05, "meaning", "kg", 0.0, None, (), True)
    assert config_writer._value(info.default) == "1.0e-05"
    assert config_writer._comment(info) == "[kg] meaning; at least 0"
