"""Hostile files of each kind: whole ones to begin with, damage to them, and the readers they are given to."""

from __future__ import annotations

import random
import struct
from abc import ABC, abstractmethod
from pathlib import Path

import zstandard

from follower_humanoid.bag.reader import read_run
from follower_humanoid.core.yaml_file import read_yaml
from follower_humanoid.errors import ConfigurationError, PhysicsError
from follower_humanoid.faults.mutations import XML_TOKENS, YAML_TOKENS, damaged_bytes, damaged_text
from follower_humanoid.faults.short_bag import short_bag
from follower_humanoid.gait.sequence import load_sequence
from follower_humanoid.graph.config_file import load_parameters
from follower_humanoid.graph.simulate import TICK
from follower_humanoid.leader.programme import load_programme
from follower_humanoid.plant.simulator import Simulator, SimulatorConfig, SimulatorInputs
from follower_humanoid.replay.index import index_bag
from follower_humanoid.resources import share_path
from follower_humanoid.robot.model import RobotModel
from follower_humanoid.ros.run_files import check_files

MIB = 2**20


class HostileFiles(ABC):
    """One kind of file.

    Attributes:
        suffix: Of its name.
    """

    suffix = ""

    @abstractmethod
    def content(self, number: int, rng: random.Random) -> bytes:
        """A hostile file; `number` counts from 0, so that chosen ones come first."""

    @abstractmethod
    def read(self, path: Path) -> None:
        """Does with the file what the program does with it.

        Raises:
            ConfigurationError: It was refused, as it may be.
        """


class HostileYaml(HostileFiles):
    """Force programmes, sequences of primitives and parameter files."""

    suffix = ".yaml"
    _CHOSEN = (
        "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n",
        "!!python/object/apply:os.system ['true']\n",
        "[" * 100_000,
        "{a: " * 50_000,
        "- {until: 1" + "0" * 5000 + ", left: [1, 2, 3]}\n",
        "x" * 2_000_000,
        "? " * 20_000,
    )

    def __init__(self, folder: Path) -> None:
        """Args: a folder for files to begin with, not needed here."""
        parameters = share_path("config/follower.yaml").read_text(encoding="utf-8")
        self._whole = [
            share_path(f"config/{name}").read_text(encoding="utf-8")
            for name in ("programmes/fig4.yaml", "programmes/compliance.yaml", "sequences/half_step.yaml")
        ]
        blocks = parameters.split("\n\n")
        self._whole += [block for block in blocks if "ros__parameters" in block and len(block) < 3000]

    def content(self, number: int, rng: random.Random) -> bytes:
        """Damaged text, now and then with bytes that are no UTF-8."""
        if number < len(self._CHOSEN):
            return self._CHOSEN[number].encode()
        text = damaged_text(rng.choice(self._whole), YAML_TOKENS, rng).encode()
        return damaged_bytes(text, rng) if rng.random() < 0.1 else text

    def read(self, path: Path) -> None:
        """By every reader of such files."""
        content, refusals = read_yaml(path), []
        del content
        for load in (load_programme, load_sequence, lambda name: load_parameters([name])):
            try:
                load(str(path))
            except ConfigurationError as error:
                refusals.append(error)
        if len(refusals) == 3:
            raise refusals[0]


class HostileUrdf(HostileFiles):
    """Robot descriptions."""

    suffix = ".urdf"

    def __init__(self, folder: Path) -> None:
        """Args: a folder for files to begin with, not needed here."""
        self._whole = share_path("urdf/follower.urdf").read_text(encoding="utf-8")
        bomb = '<?xml version="1.0"?><!DOCTYPE r [<!ENTITY a0 "aaaaaaaaaa">' + "".join(
            f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(9)
        )
        mesh = '<visual><geometry><mesh filename="/etc/passwd"/></geometry></visual><inertial>'
        self._chosen = (
            bomb + ']><robot name="&a9;"></robot>',
            '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
            + self._whole.replace("follower", "&x;", 1),
            self._whole.replace("<inertial>", mesh, 1),
            self._whole.replace("<inertial>", mesh.replace("visual", "collision"), 1),
            "<robot>" + "<link>" * 50_000,
            "<robot name='r'><link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='a'/>"
            "</joint></robot>",
            "<" * 3_000_000,
        )

    def content(self, number: int, rng: random.Random) -> bytes:
        """Damaged text, now and then with bytes that are no UTF-8."""
        if number < len(self._chosen):
            return self._chosen[number].encode()
        text = damaged_text(self._whole, XML_TOKENS, rng).encode()
        return damaged_bytes(text, rng) if rng.random() < 0.1 else text

    def read(self, path: Path) -> None:
        """As before a start, when everything is checked, then as the simulator begins with it."""
        check_files({"simulator": {"urdf": str(path)}})
        simulator = Simulator(SimulatorConfig(), RobotModel(str(path)), TICK)
        try:
            for _ in range(3):
                simulator.advance(SimulatorInputs())
        except PhysicsError as error:  # it ends the run with a word, as it should
            raise ConfigurationError(str(error)) from None
        finally:
            simulator.close()


# An empty message on a channel that is there, and no record at all; how large the chunk becomes unpacked
# and how large it says it is.
_EMPTY = struct.pack("<BQHIQQ", 0x05, 22, 1, 0, 1, 1)
_BOMBS = (
    (_EMPTY, 31 * MIB, 31 * MIB),
    (_EMPTY, 1024 * MIB, 1024 * MIB),
    (_EMPTY, 1024 * MIB, 1 * MIB),
    (b"\0", 16 * MIB, 16 * MIB),
    (b"\0", 1 * MIB, 2**62),
)


class HostileBag(HostileFiles):
    """Recorded runs."""

    suffix = ".mcap"

    def __init__(self, folder: Path) -> None:
        """Args: a folder for bags to begin with."""
        self._folder = folder
        self._whole = short_bag(folder / "whole").read_bytes()

    def content(self, number: int, rng: random.Random) -> bytes:
        """Bombs, then bags damaged on disk or, every other time, in a message before it was recorded."""
        if number < len(_BOMBS):
            return self._bomb(*_BOMBS[number])
        if number % 2:
            return damaged_bytes(self._whole, rng, spare=8)
        folder = self._folder / f"damaged_{number}"
        file = short_bag(folder, lambda data: damaged_bytes(data, rng) if rng.random() < 0.02 else data)
        return file.read_bytes()

    def _bomb(self, record: bytes, size: int, declared: int) -> bytes:
        """The bag with a chunk in front that unpacks to a multitude of one record."""
        block = record * (MIB // len(record))
        packer = zstandard.ZstdCompressor(level=1).compressobj()
        packed = b"".join(packer.compress(block) for _ in range(size // MIB)) + packer.flush()
        name = b"zstd"
        body = (
            struct.pack("<QQQII", 0, 1, declared, 0, len(name))
            + name
            + struct.pack("<Q", len(packed))
            + packed
        )
        header_end = 8 + 9 + struct.unpack_from("<Q", self._whole, 9)[0]
        chunk = struct.pack("<BQ", 0x06, len(body)) + body
        return self._whole[:header_end] + chunk + self._whole[header_end:]

    def read(self, path: Path) -> None:
        """As the report reads it, and as the player looks it through."""
        index_bag(path)
        read_run(path)


KINDS: dict[str, type[HostileYaml] | type[HostileUrdf] | type[HostileBag]] = {
    "YAML": HostileYaml, "URDF": HostileUrdf, "MCAP": HostileBag,
}  # fmt: skip
