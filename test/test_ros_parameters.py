"""ROS parameters are the configuration dataclasses: same names, ranges, defaults; bad values are named."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
import rclpy
from rcl_interfaces.msg import ParameterType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from follower_humanoid.core.config import parameter, parameters_of
from follower_humanoid.errors import ConfigurationError
from follower_humanoid.ros.parameters import LiveConfig, declare


@dataclass(frozen=True)
class Spring:
    stiffness: float = parameter(5.0, "stiffness", "N/m", 0.0, 10.0, read_only=False)


@dataclass(frozen=True)
class Config:
    count: int = parameter(3, "how many", "", 1, 9)
    name: str = parameter("dcm", "law", choices=("dcm", "pid"))
    on: bool = parameter(True, "whether")
    place: tuple[float, ...] = parameter((1.0, 2.0), "where", "m", -5.0, 5.0)
    free: float = parameter(0.0, "any number")
    spring: Spring = field(default_factory=Spring)

    def __post_init__(self) -> None:
        if self.on and self.spring.stiffness == 7.0:
            raise ConfigurationError("spring.stiffness = 7.0: not while on")


@pytest.fixture
def make_node():
    context = Context()
    rclpy.init(context=context)
    nodes = []

    def make(*arguments: str) -> Node:
        arguments = ("--ros-args", *(word for a in arguments for word in ("-p", a))) if arguments else ()
        nodes.append(Node("subject", context=context, cli_args=list(arguments), enable_rosout=False))
        return nodes[-1]

    yield make
    for node in nodes:
        node.destroy_node()
    rclpy.shutdown(context=context)


def test_defaults(make_node):
    node = make_node()
    assert declare(node, Config) == Config()
    assert node.get_parameter("spring.stiffness").value == 5.0


def test_values_from_the_command_line(make_node):
    node = make_node("count:=5", "name:=pid", "on:=false", "place:=[0.5,-1.0]", "spring.stiffness:=2.5")
    assert declare(node, Config) == Config(5, "pid", False, (0.5, -1.0), 0.0, Spring(2.5))


def test_a_whole_number_will_do_where_a_real_one_is_asked_for(make_node):
    assert declare(make_node("spring.stiffness:=3", "free:=-2"), Config).spring.stiffness == 3.0


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("count:=10", "subject: count = 10: valid: 1 to 9"),
        ("count:=2.5", "count = 2.5: needs a whole number"),
        ("count:=many", "count = 'many': needs a number"),
        ("spring.stiffness:=-0.1", "spring.stiffness = -0.1: valid: 0.0 to 10.0 N/m"),
        ("spring.stiffness:=.nan", "spring.stiffness = nan: needs a finite number"),
        ("free:=.inf", "free = inf: needs a finite number"),
        ("name:=lqr", "name = 'lqr': valid: dcm, pid"),
        ("on:=1", "on = 1: needs true or false"),
        ("place:=[1.0]", "place has 1 entries: needs 2"),
        ("place:=[1.0, 9.0]", "place = 9.0: valid: -5.0 to 5.0 m"),
    ],
)
def test_a_bad_value_is_named_with_its_bound(make_node, argument, words):
    with pytest.raises(ConfigurationError) as error:
        declare(make_node(argument), Config)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_descriptions_say_meaning_unit_and_range(make_node):
    node = make_node()
    declare(node, Config, adjustable=True)
    stiffness = node.describe_parameter("spring.stiffness")
    assert stiffness.description == "stiffness [N/m]"
    limits = stiffness.floating_point_range[0]
    assert (limits.from_value, limits.to_value) == (0, 10)
    assert stiffness.type == ParameterType.PARAMETER_DOUBLE
    assert not stiffness.read_only
    assert node.describe_parameter("count").integer_range[0].to_value == 9
    assert node.describe_parameter("count").read_only
    assert "dcm, pid" in node.describe_parameter("name").additional_constraints


def test_nothing_is_adjustable_unless_the_component_can_take_it(make_node):
    node = make_node()
    declare(node, Config)
    assert all(node.describe_parameter(info.name).read_only for info in parameters_of(Config))


def set_stiffness(node, value):
    return node.set_parameters([Parameter("spring.stiffness", value=value)])[0]


def test_a_change_reaches_the_component_and_a_bad_one_does_not(make_node):
    node = make_node()
    taken = []
    live = LiveConfig(node, declare(node, Config, adjustable=True), lambda *given: taken.append(given))
    assert live is not None
    assert set_stiffness(node, 6.0).successful
    ((config, changed),) = taken
    assert config == Config(spring=Spring(6.0))
    assert [(parameter.name, parameter.value) for parameter in changed] == [("spring.stiffness", 6.0)]
    for value, words in ((11.0, "range"), (float("nan"), "nan"), (7.0, "not while on")):
        answer = set_stiffness(node, value)
        assert not answer.successful
        assert words in answer.reason
    assert not node.set_parameters([Parameter("count", value=4)])[0].successful
    assert len(taken) == 1
    assert node.get_parameter("spring.stiffness").value == 6.0
