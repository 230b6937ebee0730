"""The scene: robot, ground, footprints, support polygon, ZMP, CoM, capture point, forces, trail.

It is drawn into viser's scene. Everything hangs below the frame `/world`; when the picture follows the robot,
that frame moves the other way, so that nobody's camera is touched.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import viser

from follower_humanoid.core.samples import SIDES, Array, Footsteps
from follower_humanoid.pictures.palette import (
    DCM,
    FOOT_FORCE_SCALE,
    FORCE,
    HAND_FORCE_SCALE,
    PCM,
    PUSH_SCALE,
    ZMP,
    rgb,
)
from follower_humanoid.viewer.figure import Figure
from follower_humanoid.viewer.footprints import Footprints
from follower_humanoid.viewer.meshes import disc, fan, light, rim
from follower_humanoid.viewer.moment import Moment, Trail
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.telling import Place, tell_moved

_CORNERS = 12  # of a support polygon: two feet of six points
_POINTS = {"com": (PCM, 0.030), "zmp": (ZMP, 0.022), "dcm": (DCM, 0.026)}
_PHONE = 0.7  # width by height of an upright screen
_DIMMED = 0.6
_NOTHING = 0.05  # a shorter arrow is not drawn [m]
# Heights over the ground and what lies on it [m].
_POLYGON, _POINT = 0.006, 0.009


def place_camera(server: viser.ViserServer) -> None:
    """Where a page begins to look from: the right and the front of the robot."""
    server.initial_camera.position = (2.0, -2.3, 1.45)
    server.initial_camera.look_at = (0.05, 0.0, 0.78)
    server.initial_camera.fov = 0.72


def suit_camera(client: viser.ClientHandle) -> None:
    """On a phone, where controls cover the lower part, looks from farther away and below the robot."""
    camera = client.camera
    if camera.image_width < _PHONE * camera.image_height:
        with client.atomic():
            camera.position, camera.look_at = (4.0, -4.65, 0.85), (0.05, 0.0, -0.5)


class Stage:
    """Draws moments into a scene."""

    def __init__(self, scene: viser.SceneApi, skeleton: Skeleton) -> None:
        """Puts everything there, the robot standing at the origin."""
        self._scene, self._skeleton = scene, skeleton
        self._world = Place(scene.add_frame("/world", show_axes=False))
        self._lay_ground()
        self._figure = Figure(scene, "/world/robot", skeleton)
        self._glass = False
        self.show_through(True)
        self._points = {name: self._add_point(name, *look) for name, look in _POINTS.items()}
        self._places = {name: Place(handle) for name, handle in self._points.items()}
        self._polygon = self._add_polygon()
        self._hand_arrows = self._add_arrows("hands", FORCE, 0.012)
        self._foot_arrows = self._add_arrows("feet", FORCE, 0.012)
        self._footprints = Footprints(scene, "/world/footsteps", skeleton)

    @property
    def skeleton(self) -> Skeleton:
        """The posture that is shown."""
        return self._skeleton

    @property
    def offset(self) -> Array:
        """Where the origin of world is in the picture, shape (3,) [m]."""
        return np.array(self._world.xyz)

    def draw(self, moment: Moment, trail: Trail) -> None:
        """Shows a moment, all of it."""
        self.draw_robot(moment)
        self.draw_points(moment)
        self.draw_forces(moment)
        self.draw_footprints(moment, trail)

    def draw_robot(self, moment: Moment, follow: bool = True) -> None:
        """Shows its posture; `follow` keeps it in the middle of the picture."""
        if moment.has_robot:
            x, y, _ = moment["odom"].position.tolist()
            self._skeleton.place(moment["odom"], moment["joint_states"])
            self._figure.move()
            self._world.move(*((-x, -y, 0.0) if follow else (0.0, 0.0, 0.0)))

    def draw_points(self, moment: Moment) -> None:
        """Shows ZMP, CoM, capture point, and the support polygon."""
        for number, (name, handle) in enumerate(self._points.items()):
            handle.visible = name in moment
            if name in moment:
                x, y, _ = moment[name].xyz.tolist()
                self._places[name].move(x, y, _POINT + 0.001 * number)
        vertices = moment["support_polygon"].vertices if "support_polygon" in moment else np.zeros((0, 3))
        self._polygon.visible = len(vertices) > 2
        if len(vertices) > 2:
            corners = np.minimum(np.arange(_CORNERS), len(vertices) - 1)
            flat = vertices[corners].astype(np.float32)
            flat[:, 2] = _POLYGON
            tell_moved(self._polygon, "vertices", flat)

    def draw_forces(self, moment: Moment) -> None:
        """Shows what pulls, pushes and carries it."""
        hands, feet = [], []
        for side in SIDES:
            grip = self._skeleton.position(f"{side.prefix}_gripper")
            hands.append((grip, HAND_FORCE_SCALE * moment.force(f"{side.value}_hand/applied")))
            sole = self._skeleton.pose(f"{side.prefix}_sole")
            force = sole.rotation @ moment.force(f"{side.value}_foot/wrench")
            feet.append((np.array(sole.translation), FOOT_FORCE_SCALE * force))
        pelvis = self._skeleton.position("base_link")
        hands.append((pelvis, PUSH_SCALE * moment.force("base/applied")))
        self._show_arrows(self._hand_arrows, hands)
        self._show_arrows(self._foot_arrows, feet)

    def draw_footprints(self, moment: Moment, trail: Trail) -> None:
        """Shows where it has been, and where it wants to step."""
        self._footprints.draw(trail, moment["footsteps"] if "footsteps" in moment else Footsteps(()))

    def show_through(self, glass: bool) -> None:
        """Whether lower legs and feet let through what is under them: forces, points, polygon."""
        if glass is not self._glass:
            self._glass = glass
            self._figure.show_through(glass)

    def _lay_ground(self) -> None:
        self._scene.add_grid(
            "/world/ground",
            infinite_grid=True,
            cell_size=0.25,
            section_size=1.0,
            cell_color=(206, 210, 214),
            section_color=(150, 156, 164),
            fade_distance=18.0,
            fade_strength=1.5,
            shadow_opacity=0.25,
        )

    def _add_point(self, name: str, color: str, radius: float) -> Any:
        vertices, faces = disc(radius)
        path = f"/world/points/{name}"
        # Light from above bleaches. Unlit by shadows, or it would be grey under the robot.
        dimmed = np.round(_DIMMED * np.array(rgb(color))).astype(np.uint8)
        point = self._scene.add_mesh_simple(
            path, vertices, faces, color=dimmed, cast_shadow=False, receive_shadow=False, visible=False
        )
        # Lines keep their colour in any light.
        self._scene.add_line_segments(f"{path}/rim", rim(radius), rgb(color), thickness=0.006)
        return point

    def _add_polygon(self) -> Any:
        return self._scene.add_mesh_simple(
            "/world/support_polygon",
            np.zeros((_CORNERS, 3)),
            fan(_CORNERS),
            color=(240, 196, 60),
            opacity=0.45,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )

    def _add_arrows(self, name: str, color: str, radius: float) -> Any:
        return self._scene.add_arrows(
            f"/world/forces/{name}",
            np.zeros((1, 2, 3)),
            light(np.array(rgb(color)) / 255.0),
            shaft_radius=radius,
            head_radius=2.4 * radius,
            head_length=6.0 * radius,
            visible=False,
        )

    @staticmethod
    def _show_arrows(handle: Any, arrows: Sequence[tuple[Array, Array]]) -> None:
        shown = [(start, start + arrow) for start, arrow in arrows if np.linalg.norm(arrow) > _NOTHING]
        handle.visible = bool(shown)
        if shown:
            tell_moved(handle, "points", np.array(shown, dtype=np.float32))
