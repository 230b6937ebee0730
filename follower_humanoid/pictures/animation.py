"""A run in 3D as a page of its own: the viewer's scene, recorded frame by frame."""

from __future__ import annotations

import io
from contextlib import redirect_stdout

import viser

from follower_humanoid.pictures.style import View
from follower_humanoid.viewer.skeleton import Skeleton
from follower_humanoid.viewer.stage import Stage, place_camera
from follower_humanoid.viewer.tape import Tape

FRAMES_PER_SECOND = 25
_LARGEST = 4000  # frames; a longer run is shown with fewer a second


def animation(view: View) -> str:
    """HTML that plays the run, with everything it needs in it: slider, speed, camera."""
    tape = Tape(view.run)
    with redirect_stdout(io.StringIO()):  # the library announces a server, which nobody is to visit
        server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    try:
        stage = Stage(server.scene, Skeleton(view.body.urdf, view.run.joint_names))
        place_camera(server)
        server.scene.configure_default_lights(cast_shadow=False)  # it shall play anywhere
        recorded = server.get_scene_serializer()
        length = tape.end - tape.begin
        frames = max(1, min(round(FRAMES_PER_SECOND * length), _LARGEST))
        with server.atomic():  # nobody listens: the server's thread need not be woken for each message
            for frame in range(frames + 1):
                time = tape.begin + length * frame / frames
                stage.draw(tape.moment(time), tape.trail(time))
                recorded.insert_sleep(length / frames)
        return str(recorded.as_html())
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()
