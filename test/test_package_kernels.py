"""What the cache of compiled kernels relies on."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "follower_humanoid"
# A type, an error raised by name, and two numbers that are what they are.
# And what makes a function of a C library callable by a name and types that are said where it is called.
TIMELESS = {"Array", "PhysicsError", "BASE_DOF", "GRAVITY", "external"}
FILES = [
    path for path in sorted(PACKAGE.rglob("*.py")) if "core.kernel import" in path.read_text(encoding="utf-8")
]


def is_kernel(node: ast.AST) -> bool:
    return isinstance(node, ast.FunctionDef) and any(
        getattr(getattr(mark, "func", mark), "id", "") in {"kernel", "kernel_part"}
        for mark in node.decorator_list
    )


def imported_from_package(tree: ast.Module) -> set[str]:
    return {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("follower_humanoid")
        for alias in node.names
    }


def made_of(foreign: set[str], tree: ast.Module) -> set[str]:
    """Names of a module whose values come from foreign ones."""
    return {
        target.id
        for statement in tree.body
        if isinstance(statement, ast.Assign)
        and any(isinstance(name, ast.Name) and name.id in foreign for name in ast.walk(statement.value))
        for target in statement.targets
        if isinstance(target, ast.Name)
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_kernel_uses_nothing_of_other_files_since_its_cache_would_not_notice_a_change_there(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    foreign = imported_from_package(tree) - TIMELESS
    foreign |= made_of(foreign, tree)
    used = {
        f"{kernel.name}: {name.id}"
        for kernel in ast.walk(tree)
        if is_kernel(kernel)
        for statement in kernel.body
        for name in ast.walk(statement)
        if isinstance(name, ast.Name) and name.id in foreign
    }
    assert not used


def test_there_are_kernels_to_look_at():
    assert len(FILES) > 5
