"""A ROS 2 that is only what a script imports: an arm that stands somewhere, and a controller that takes goals."""

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace
from typing import Any


class Message(SimpleNamespace):
    """A message whose lists are empty unless given."""

    def __init__(self, **fields: Any) -> None:
        super().__init__(**({"points": [], "path_tolerance": [], "goal_tolerance": []} | fields))


class Ros:
    """What the script sees, and what it sent."""

    def __init__(self, names: Sequence[str], standing: Sequence[float], speed: float = 0.0, code: int = 0) -> None:
        self.names, self.standing, self.speed, self.code = list(names), list(standing), speed, code
        self.goals: list[Any] = []
        self.hears: Any = None
        self.server = ""

    def spin_once(self, node: Any, timeout_sec: float) -> None:
        """The joints in two messages, as from a gripper's driver and an arm's."""
        if self.hears is not None:
            self.standing = [q + self.speed for q in self.standing]
            self.hears(Message(name=["finger", *self.names[:2]], position=[0.0, *self.standing[:2]]))
            self.hears(Message(name=self.names[2:], position=self.standing[2:]))

    def create_subscription(self, kind: Any, topic: str, hears: Any, qos: Any) -> str:
        """Of the joint states."""
        self.hears = hears
        return topic

    def destroy_subscription(self, subscription: Any) -> None:
        """Nothing is heard any more."""
        self.hears = None

    def destroy_node(self) -> None:
        """Nothing."""

    def send_goal_async(self, goal: Any) -> Any:
        """A handle of a goal that is accepted and ends at once."""
        self.goals.append(goal)
        result = Message(result=Message(error_code=self.code, error_string="off its path"))
        handle = Message(accepted=True, get_result_async=lambda: Message(result=lambda: result))
        return Message(result=lambda: handle)

    @property
    def trajectory(self) -> dict[str, Any]:
        """The only trajectory that was sent, as values."""
        (goal,) = self.goals
        return json.loads(json.dumps(goal.trajectory, default=vars))

    @contextmanager
    def installed(self) -> Iterator[None]:
        """While this lasts, scripts import it."""
        goal = type("FollowJointTrajectory", (), {"Goal": Message, "Result": SimpleNamespace(SUCCESSFUL=0)})

        def client(node: Any, kind: Any, name: str) -> Any:
            self.server = name
            return Message(wait_for_server=lambda timeout_sec: True, send_goal_async=self.send_goal_async)

        modules: dict[str, dict[str, Any]] = {
            "rclpy": {
                "init": lambda: None,
                "shutdown": lambda: None,
                "create_node": lambda name: self,
                "spin_once": self.spin_once,
                "spin_until_future_complete": lambda node, future: None,
            },
            "rclpy.action": {"ActionClient": client},
            "rclpy.qos": {"qos_profile_sensor_data": None},
            "builtin_interfaces": {},
            "builtin_interfaces.msg": {"Duration": Message},
            "control_msgs": {},
            "control_msgs.action": {"FollowJointTrajectory": goal},
            "control_msgs.msg": {"JointTolerance": Message},
            "sensor_msgs": {},
            "sensor_msgs.msg": {"JointState": Message},
            "trajectory_msgs": {},
            "trajectory_msgs.msg": {"JointTrajectory": Message, "JointTrajectoryPoint": Message},
        }
        for name, entries in modules.items():
            module = ModuleType(name)
            vars(module).update(entries)
            sys.modules[name] = module
        try:
            yield
        finally:
            for name in modules:
                del sys.modules[name]
