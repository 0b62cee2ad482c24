"""Serves a class to the library of an FMU that `rexrov.component` wrote; it is in the FMU's resources.

    python host.py RESOURCES            its stdin is a socket to the library
    python host.py RESOURCES --check    creates an object and reports whether its state can be saved

The process imports the class's module once. It forks for each instance, so that no run sees what another has
left in modules. The child creates the object and answers until it is no longer needed, and the parent reports the end
of the child. A message is its length, a letter and that many bytes, little-endian; the library's
`process.rs` lists the messages.
"""

from __future__ import annotations

import contextlib
import fcntl
import importlib.util
import json
import math
import os
import pickle
import random
import select
import signal
import socket
import struct
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

MAKE, STEP, SAVE, RESTORE, END = b"MSGRE"
DONE, FAILED, LOST = b".!x"
#: The exit status of a child whose object is no longer needed: one that no class ends with.
ORDERLY = 77
HEAD = struct.Struct("<IB")


class Wrong(Exception):
    """An error of the class, reported in full."""


class Channel:
    """The socket."""

    def __init__(self) -> None:
        self.socket = socket.socket(fileno=os.dup(0))

    def receive(self) -> tuple[int, bytes] | None:
        """The next message: its letter, and all of it; None if the library is gone."""
        message = self.socket.recv(1 << 16)
        while True:
            if len(message) >= HEAD.size:
                length, letter = HEAD.unpack_from(message)
                if len(message) == HEAD.size + length:
                    return letter, message
            more = self.socket.recv(1 << 20)
            if not more:
                return None
            message += more

    def send(self, letter: int, octets: bytes = b"") -> None:
        self.socket.sendall(HEAD.pack(len(octets), letter) + octets)

    def watch(self, on: bool) -> None:
        """While on, the kernel ends this process by SIGIO when the library is gone, whatever the process is doing."""
        flags = fcntl.fcntl(self.socket, fcntl.F_GETFL)
        fcntl.fcntl(self.socket, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(self.socket, fcntl.F_SETFL, flags | os.O_ASYNC if on else flags & ~os.O_ASYNC)

    def guard(self, child: int) -> int:
        """The exit status of a child, which is terminated if the library is gone."""
        ended, poll = os.pidfd_open(child), select.poll()
        poll.register(ended, select.POLLIN)
        poll.register(self.socket, select.POLLRDHUP)
        while ended not in dict(poll.poll()):
            with contextlib.suppress(PermissionError):
                os.kill(child, signal.SIGKILL)
            poll.unregister(self.socket)
        os.close(ended)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _row(places: list[int]) -> Sequence[int]:
    """Adjacent places as a range: a slice is faster than a selection."""
    row = range(places[0], places[-1] + 1)
    return row if places == list(row) else places


class Ports:
    """Names of values, and of groups of them: `dvl.velocity` is the array of all `dvl.velocity.*`."""

    def __init__(self, names: list[str]) -> None:
        self.names = names
        self.places = {name: place for place, name in enumerate(names)}
        groups: dict[str, list[int]] = {}
        for place, name in enumerate(names):
            parts = name.split(".")
            for length in range(1, len(parts)):
                groups.setdefault(".".join(parts[:length]), []).append(place)
        self.groups = {name: _row(places) for name, places in groups.items()}

    def unknown(self, name: object) -> str:
        known = [*self.places, *self.groups]
        likely = get_close_matches(str(name), known, 1, 0.5)
        hint = f"did you mean '{likely[0]}'?" if likely else f"there are {', '.join(self.names)}"
        return f"there is no '{name}'; {hint}"


class Measurements(Mapping[str, Any]):
    """The inputs at a step: `y["pressure.depth"]` is a number, `y["dvl.velocity"]` an array of all below."""

    __slots__ = ("_ports", "_values", "_seen", "_new")

    def __init__(self, ports: Ports, values: Sequence[float], seen: dict[str, float]) -> None:
        self._ports, self._values, self._seen = ports, values, seen
        self._new: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Any:
        place = self._ports.places.get(name)
        if place is not None:
            return self._values[place]
        group = self._ports.groups.get(name)
        if group is None:
            raise KeyError(self._ports.unknown(name))
        if type(group) is range:
            return np.array(self._values[group.start : group.stop])
        return np.array([self._values[place] for place in group])

    def __iter__(self) -> Iterator[str]:
        return iter(self._ports.names)

    def __len__(self) -> int:
        return len(self._values)

    def new(self, sensor: str) -> bool:
        """Whether there is a new measurement of a sensor: its `valid` is 1 and its
        `stamp` differs from that of the last new one."""
        if sensor in self._new:
            return True
        stamp = self[f"{sensor}.stamp"]
        if not self[f"{sensor}.valid"] >= 0.5 or stamp == self._seen.get(sensor):
            return False
        self._seen[sensor] = stamp
        self._new = (*self._new, sensor)
        return True


class Object:
    """An object of the class and its environment."""

    def __init__(self, cls: type, manifest: Mapping[str, Any]) -> None:
        self.cls = cls
        self.inputs, self.outputs = Ports(manifest["inputs"]), Ports(manifest["outputs"])
        self.numbers = struct.Struct(f"<{1 + len(self.inputs.names)}d")
        self.given = struct.Struct(f"<{len(self.outputs.names)}d")
        #: The current activity, or the time of a step.
        self.doing: str | float = "__init__"
        self.own: Any = None
        self.seen: dict[str, float] = {}

    def make(self, parameters: Mapping[str, Any]) -> None:
        self.doing = "__init__"
        self.seen = {}
        # For classes that use these: the same numbers in each run with the same seed.
        seed = parameters.get("seed", 0)
        random.seed(seed)
        np.random.seed(abs(seed) if isinstance(seed, int) else 0)
        self.own = self.cls(**parameters)

    def step(self, message: bytes) -> bytes:
        t, *values = self.numbers.unpack_from(message, HEAD.size)
        self.doing = t
        estimate = self.own.step(t, Measurements(self.inputs, values, self.seen))
        given = self.flat(estimate)
        if not math.isfinite(sum(given)):
            self.refuse(given)
        return self.given.pack(*given)

    def flat(self, estimate: Any) -> Sequence[float]:
        """The outputs in their order."""
        if not isinstance(estimate, Mapping):
            return self.sized(estimate, self.outputs.names, "the estimate")
        values: list[Any] = [None] * len(self.outputs.names)
        for name, value in estimate.items():
            place = self.outputs.places.get(name)
            if place is not None:
                values[place] = self.number(value, name)
                continue
            group = self.outputs.groups.get(name)
            if group is None:
                raise Wrong(f"gives '{name}', and {self.outputs.unknown(name)}")
            for member, part in zip(group, self.sized(value, group, f"'{name}'")):
                values[member] = part
        if None in values:
            raise Wrong(f"gives no '{self.outputs.names[values.index(None)]}'")
        return values

    def sized(self, value: Any, places: Sequence[Any], what: str) -> list[float]:
        """The numbers of a sequence that has exactly as many as there are places."""
        wanted = len(places)
        if value is None:
            raise Wrong(f"gives nothing as {what}, which has {wanted} numbers")
        try:
            array: npt.NDArray[np.float64] = np.asarray(value, float)
        except (TypeError, ValueError):
            raise Wrong(f"gives {value!r} as {what}, which has {wanted} numbers") from None
        if array.shape not in ((wanted,), (wanted, 1), (1, wanted)):
            raise Wrong(f"gives an array of shape {array.shape} as {what}, which has {wanted} numbers")
        numbers: list[float] = array.ravel().tolist()
        return numbers

    def number(self, value: Any, name: str) -> float:
        if type(value) is float:
            return value
        try:
            array = np.asarray(value if value is not None else (), float)
        except (TypeError, ValueError):
            raise Wrong(f"gives {value!r} as '{name}', which is a number") from None
        if array.size != 1:
            raise Wrong(f"gives an array of shape {array.shape} as '{name}', which is a number")
        return float(array.item())

    def refuse(self, values: Sequence[float]) -> None:
        for name, value in zip(self.outputs.names, values):
            if not math.isfinite(value):
                raise Wrong(f"gives {value} as '{name}'")

    def save(self) -> bytes:
        self.doing = "saving the state"
        return pickle.dumps((self.own, self.seen), pickle.HIGHEST_PROTOCOL)

    def restore(self, octets: bytes) -> None:
        self.doing = "restoring a state"
        self.own, self.seen = pickle.loads(octets)

    def answer(self, letter: int, message: bytes) -> bytes:
        """The answer to a request."""
        if letter == STEP:
            return self.step(message)
        if letter == SAVE:
            return self.save()
        if letter == MAKE:
            self.make(json.loads(message[HEAD.size :]))
        else:
            self.restore(message[HEAD.size :])
        return b""

    def described(self, error: BaseException) -> str:
        """The error, in one line."""
        doing = self.doing if isinstance(self.doing, str) else f"step at t = {self.doing!r} s"
        if isinstance(error, Wrong):
            return f"{self.cls.__name__}.{doing} {error}"
        return f"{self.cls.__name__}.{doing}: {described(error)}"


def described(error: BaseException) -> str:
    """An exception with its traceback in the class."""
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith("<frozen ")]
    frames = [f for f in frames if f.filename != __file__]
    where = [f"{Path(f.filename).name}:{f.lineno} in {f.name}: {f.line}" for f in frames[-6:]]
    return f"{text} ({'; '.join(where)})" if where else text


def load(resources: str, manifest: Mapping[str, Any]) -> type:
    """The class of the module in the resources."""
    code = Path(resources, "code")
    sys.path.insert(0, str(code))
    # A script that makes its own FMU must not do so here: see components.py.
    os.environ["REXROV_HOST"] = manifest["module"]
    name = Path(manifest["module"]).stem
    spec = importlib.util.spec_from_file_location(name, code / manifest["module"])
    assert spec is not None and spec.loader is not None, "the name of a file of Python ends with .py"
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    cls: type = getattr(module, manifest["class"])
    return cls


def serve(channel: Channel, made: Object, message: tuple[int, bytes] | None) -> None:
    """Answers in a child, until the object is no longer needed."""
    while message is not None and message[0] != END:
        try:
            reply = DONE, made.answer(*message)
        except BaseException as error:
            reply = FAILED, made.described(error).encode(errors="replace")
        channel.send(*reply)
        message = channel.receive()


def main(resources: str) -> None:
    channel = Channel()
    channel.watch(True)
    manifest = json.loads(Path(resources, "component.json").read_text())
    try:
        made, reply = Object(load(resources, manifest), manifest), (DONE, b"")
    except BaseException as error:
        reply = LOST, f"{manifest['module']} cannot be imported: {described(error)}".encode()
    channel.watch(False)
    channel.send(*reply)
    while reply[0] == DONE and (message := channel.receive()) is not None:
        if message[0] == END:
            channel.send(DONE)
            continue
        child = os.fork()
        if child == 0:
            try:
                serve(channel, made, message)
            finally:
                os._exit(ORDERLY)
        code = channel.guard(child)
        if code == ORDERLY:
            channel.send(DONE)
        else:
            how = f"ended with exit status {code}" if code >= 0 else f"was killed by {signal.Signals(-code).name}"
            reply = LOST, f"the process of {manifest['class']} {how}".encode()
            channel.send(*reply)


def check(resources: str) -> dict[str, str]:
    """Whether an object can be created, and its state saved; as JSON."""
    manifest = json.loads(Path(resources, "component.json").read_text())
    made: Object | None = None
    try:
        made = Object(load(resources, manifest), manifest)
        made.make({parameter["name"]: parameter["start"] for parameter in manifest["parameters"]})
    except BaseException as error:
        wrong = made.described(error) if made else f"{manifest['module']} cannot be imported: {described(error)}"
        return {"wrong": wrong}
    try:
        made.restore(made.save())
    except Exception as error:
        return {"unsaved": described(error)}
    return {}


if __name__ == "__main__":
    if sys.argv[2:] == ["--check"]:
        found, sys.stdout = sys.stdout, sys.stderr
        print(json.dumps(check(sys.argv[1])), file=found)
    else:
        try:
            main(sys.argv[1])
        except (BrokenPipeError, ConnectionResetError):
            pass
