"""A request that cannot be read is refused in words, and the node lives on."""

from __future__ import annotations

import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue, SetParametersResult
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter as RclpyParameter

from follower_humanoid.ros.careful_services import careful

GOOD = Parameter(name="good", value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=1.0))
STRANGE = Parameter(name="strange", value=ParameterValue(type=255))


class Services:
    """As rclpy's, which trip over a type that there is not."""

    def __init__(self):
        self.set, self.refused = [], []

    def answer_set(self, request, response):
        for parameter in request.parameters:
            self.set.append(RclpyParameter.from_parameter_msg(parameter).name)
            response.results.append(SetParametersResult(successful=True))
        return response

    def answer_set_atomically(self, request, response):
        self.answer_set(request, SetParameters.Response())
        response.result = SetParametersResult(successful=True)
        return response

    def careful(self, kind, answer):
        return careful("leg_controller/some", kind, answer, self.refused.append)


def test_rclpy_still_trips_over_it():
    with pytest.raises(ValueError, match="255"):
        Services().answer_set(SetParameters.Request(parameters=[STRANGE]), SetParameters.Response())


def test_the_others_of_a_request_are_set_all_the_same():
    services = Services()
    answer = services.careful(SetParameters, services.answer_set)
    response = answer(SetParameters.Request(parameters=[GOOD, STRANGE, GOOD]), SetParameters.Response())
    assert [result.successful for result in response.results] == [True, False, True]
    assert "255" in response.results[1].reason
    assert services.set == ["good", "good"]
    assert "request to leg_controller/some refused" in str(services.refused[0])


def test_all_or_nothing_is_refused_as_a_whole():
    services = Services()
    answer = services.careful(SetParametersAtomically, services.answer_set_atomically)
    request = SetParametersAtomically.Request(parameters=[STRANGE])
    response = answer(request, SetParametersAtomically.Response())
    assert not response.result.successful
    assert response.result.reason


@pytest.mark.parametrize(
    ("parameter", "reason"),
    [
        (Parameter(name="nowhere", value=GOOD.value), "no parameter 'nowhere'"),
        (Parameter(name="", value=GOOD.value), "no parameter ''"),
        (Parameter(name="good"), "cannot be undeclared"),
    ],
)
def test_what_is_not_there_is_not_set_and_what_is_there_stays(parameter, reason):
    services = Services()
    answer = careful("x", SetParameters, services.answer_set, services.refused.append, "good".__eq__)
    response = answer(SetParameters.Request(parameters=[parameter]), SetParameters.Response())
    assert not response.results[0].successful
    assert reason in response.results[0].reason
    assert services.set == []


def test_any_other_request_gets_an_empty_answer():
    services = Services()
    answer = services.careful(GetParameters, lambda request, response: request.nothing)
    assert answer(GetParameters.Request(), GetParameters.Response()) == GetParameters.Response()
    assert len(services.refused) == 1
