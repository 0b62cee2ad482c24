"""`--live`: a run is watched and controlled from Chromium, and through Foxglove's protocol.

A browser is needed (`cargo xtask test` unpacks Debian's); without one these tests are skipped.
"""

import base64
import contextlib
import http.client
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser import browser, needs_chromium, problems
from conftest import COSIM, ROOT
from playwright.sync_api import expect
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

pytestmark = needs_chromium

# A busy machine is slow, not wrong.
expect.set_options(timeout=60_000)

SYSTEM = ["run", ROOT / "examples" / "baseline.ssd", "--output-interval", "0.1"]


class Live:
    """A served run, starting with its initial pause."""

    def __init__(self, folder, *arguments, system=SYSTEM):
        command = [COSIM, *system, *arguments, "--live", "--paused", "-o", "run.csv"]
        self.process = subprocess.Popen([*map(str, command)], cwd=folder, stderr=subprocess.PIPE, text=True)
        self.reported, self.page, self.foxglove = "", None, None
        while self.foxglove is None:
            line = self.process.stderr.readline()
            assert line, self.reported
            self.reported += line
            if found := re.search(r"http://\S+", line):
                self.page = found[0]
            if found := re.search(r"ws://\S+", line):
                self.foxglove = found[0]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.returncode is None:
            self.process.kill()
            self.process.communicate()

    def end(self):
        """Waits for the end, and returns all output."""
        _, rest = self.process.communicate()
        assert self.process.returncode == 0, rest
        return self.reported + rest


def plain(folder, *arguments):
    """The same run without clients; its results as bytes."""
    subprocess.run([*map(str, [COSIM, *SYSTEM, *arguments, "-q", "-o", "plain.csv"])], cwd=folder, check=True)
    return (folder / "plain.csv").read_bytes()


def status(page, term):
    return page.locator("#status div").filter(has=page.get_by_text(term, exact=True)).locator("dd")


@pytest.mark.parametrize("workers", [[], ["--workers", "2"]], ids=["one process", "workers"])
def test_a_run_is_watched_steered_and_repeated(browser, tmp_path, workers):
    arguments = ["--stop-time", "30", *workers]
    with Live(tmp_path, *arguments) as live:
        page = browser.new_page()
        wrong = problems(page)
        page.goto(live.page)
        expect(page.get_by_role("heading", level=1)).to_have_text("loop")
        expect(status(page, "state")).to_have_text("paused")
        expect(page.get_by_role("button", name="Go on")).to_be_visible()

        # A step is one output interval.
        for instant in ["0.1 s", "0.2 s"]:
            page.get_by_role("button", name="One step").click()
            expect(status(page, "time")).to_have_text(f"{instant} of 30 s")
        page.get_by_label("Signal", exact=True).fill("vehicle.velocity.?")
        page.get_by_role("button", name="Show", exact=True).click()
        expect(page.get_by_role("alert").filter(has_text="no other recorded variable")).to_be_visible()
        page.get_by_label("Signal", exact=True).fill("vehicle.velocity.*")
        page.get_by_role("button", name="Show", exact=True).click()
        expect(page.get_by_role("figure").filter(has_text="Signals in m/s (m/s)")).to_be_visible()

        # An invalid fault is reported; the run is unchanged.
        page.get_by_label("Fault").select_option(label="bias")
        page.get_by_label("on variables").fill("fix.position.xx")
        page.get_by_label("value", exact=True).fill("5")
        page.get_by_role("button", name="Inject").click()
        expect(page.get_by_role("log")).to_contain_text("did you mean 'position.x'?")
        assert not (tmp_path / "run.injected.toml").exists()
        page.get_by_label("on variables").fill("fix.position.x fix.position.y")
        page.get_by_role("button", name="Inject").click()
        expect(page.get_by_role("log")).to_contain_text("bias of fix.position.x, fix.position.y")
        page.get_by_label("Fault").select_option(label="latency")
        page.get_by_label("on variables").fill("dvl.velocity.u")
        page.get_by_label("delay", exact=True).fill("0.35")
        page.get_by_label("jitter", exact=True).fill("0.2")
        page.get_by_label("for (s)").fill("10")

        page.get_by_role("button", name="One step").click()
        expect(status(page, "time")).to_have_text("0.3 s of 30 s")
        page.get_by_role("button", name="Inject").click()
        expect(page.get_by_role("log")).to_contain_text("latency of dvl.velocity.u")
        page.get_by_label("Speed").select_option(label="as fast as it can")
        page.get_by_role("button", name="Go on").click()
        expect(status(page, "state")).to_have_text("ended")
        expect(page.get_by_role("log")).to_contain_text("the run has ended")
        expect(page.locator("#where")).to_contain_text("vehicle:")
        assert wrong == []
        page.close()
        assert "--scenario run.injected.toml repeats them" in live.end()
    watched = (tmp_path / "run.csv").read_bytes()
    assert watched == plain(tmp_path, *arguments, "--scenario", "run.injected.toml")
    assert watched != plain(tmp_path, *arguments)


def listening(pid):
    """The addresses at which a process listens, from /proc/net/tcp."""
    links = []
    for file in Path(f"/proc/{pid}/fd").iterdir():
        # It may be closed meanwhile.
        with contextlib.suppress(FileNotFoundError):
            links.append(os.readlink(file))
    sockets = {found[1] for link in links if (found := re.fullmatch(r"socket:\[(\d+)\]", link))}
    lines = [line.split() for table in ["tcp", "tcp6"] for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]]
    return [line[1].split(":")[0] for line in lines if line[3] == "0A" and line[9] in sockets]


def test_nothing_is_answered_without_the_token_and_only_this_machine_is(tmp_path):
    with Live(tmp_path, "--stop-time", "1") as live:
        assert listening(live.process.pid) == ["0100007F"]
        address = urlsplit(live.page)
        token = address.query.removeprefix("token=")

        def get(path, method="GET", headers={}):
            connection = http.client.HTTPConnection(address.hostname, address.port)
            connection.request(method, path, headers=headers)
            answer = connection.getresponse()
            return answer.status, answer.read().decode()

        assert get(f"/?token={token}")[0] == 200
        for path in ["/", "/?token=", f"/?token={token[:-1]}", f"/?token={token}0", f"/?token={token[::-1]}x"]:
            status, body = get(path)
            assert status == 403 and token not in body
        assert get(f"/other?token={token}")[0] == 404
        assert get(f"/?token={token}", method="POST")[0] == 404
        upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "x" * 22 + "=="}
        assert get("/", headers=upgrade | {"Sec-WebSocket-Protocol": "cosim.live.v1"})[0] == 403
        assert get(f"/?token={token}", headers=upgrade | {"Sec-WebSocket-Protocol": "chat"})[0] == 400
        for junk in [b"\0" * 100, b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000]:
            with socket.create_connection((address.hostname, address.port)) as line:
                # It may disconnect before it has received everything.
                with contextlib.suppress(OSError):
                    line.sendall(junk)
                    line.shutdown(socket.SHUT_WR)
                    assert line.recv(100) == b""
        assert get(f"/?token={token}")[0] == 200

    quiet = subprocess.Popen([*map(str, [COSIM, *SYSTEM, "--real-time=0.001", "--digest-file", "d", "-o", "q.csv"])], cwd=tmp_path)
    try:
        while not (tmp_path / "q.csv").exists():
            assert quiet.poll() is None
        assert listening(quiet.pid) == []
    finally:
        quiet.kill()
        quiet.wait()


def stalled(url, protocol, columns=range(300)):
    """A client that requests these columns and reads nothing."""
    address = urlsplit(url)
    line = socket.socket()
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    line.connect((address.hostname, address.port))
    key = base64.b64encode(b"0" * 16).decode()
    line.sendall(
        f"GET /?{address.query} HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: {protocol}\r\n\r\n".encode()
    )
    text = json.dumps({"op": "show", "number": 1, "columns": [*columns]}).encode()
    assert len(text) < 65536
    mask = b"\1\2\3\4"
    masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(text))
    line.sendall(b"\x81\xfe" + struct.pack(">H", len(text)) + mask + masked)
    return line


def is_connected(server, client):
    """Whether the server's side of a connection of this machine is open, from /proc/net/tcp."""
    ends = [f"0100007F:{port:04X}" for port in (server, client)]
    lines = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    return any(line[1:3] == ends and line[3] == "01" for line in lines)


def test_a_stalled_client_stops_neither_the_run_nor_others(browser, tmp_path):
    """60 s with three clients. The stalled one requests 48 MB, more than all buffers of a connection hold."""
    arguments = ["--stop-time", "60"]
    with Live(tmp_path, *arguments) as live:
        with stalled(live.page, "cosim.live.v1", [i % 100 for i in range(10_000)]) as line:
            pages = [browser.new_page() for _ in range(2)]
            for page in pages:
                page.goto(live.page)
                expect(status(page, "state")).to_have_text("paused")
            began = time.monotonic()
            pages[0].get_by_label("Speed").select_option(label="as fast as it can")
            pages[0].get_by_role("button", name="Go on").click()
            for page in pages:
                expect(status(page, "state")).to_have_text("ended")
                expect(status(page, "time")).to_have_text("60 s of 60 s")
                assert page.evaluate("livePage.store.t.at(-1)") == 60
            # A client is dropped when it has taken nothing for 10 s: the end did not wait for that.
            if time.monotonic() - began < 9:
                assert is_connected(urlsplit(live.page).port, line.getsockname()[1])
            live.end()
            # What was sent is in the buffers, and then the connection ends.
            received = 0
            with contextlib.suppress(ConnectionError):
                while part := line.recv(1 << 20):
                    received += len(part)
            assert received < 24_000_000
        for page in pages:
            page.close()
    assert (tmp_path / "run.csv").read_bytes() == plain(tmp_path, *arguments)


def wait_until(page, condition):
    """Waits until a condition holds in the page, whose policy forbids Playwright's own way."""
    page.evaluate(f"() => new Promise((done) => {{ const look = () => ({condition} ? done() : requestAnimationFrame(look)); look(); }})")


def test_a_late_client_gets_the_newest_sample(browser, tmp_path):
    """More samples than the history keeps, so that it has every second or fourth only."""
    with Live(tmp_path, "--stop-time", "600", system=[*SYSTEM[:-1], "0.01"]) as live:
        early, late = browser.new_page(), browser.new_page()
        early.goto(live.page)
        expect(status(early, "state")).to_have_text("paused")
        early.get_by_label("Speed").select_option(label="as fast as it can")
        newest = "livePage.store.t.at(-1)"
        for _ in range(3):
            before = early.evaluate("livePage.state.time")
            early.get_by_role("button", name="Go on").click()
            wait_until(early, f"livePage.state.time > {before} + 20")
            early.get_by_role("button", name="Pause").click()
            expect(status(early, "state")).to_have_text("paused")
            late.goto(live.page)
            expect(status(late, "state")).to_have_text("paused")
            wait_until(late, "livePage.store.t.length > 100")
            now = early.evaluate("livePage.state.time")
            assert [page.evaluate(newest) for page in (early, late)] == [now, now]
        gaps = late.evaluate("livePage.store.t.slice(1, 20).map((time, i) => time - livePage.store.t[i])")
        assert min(gaps) > 0.015, "the history is thinned"
        early.close()
        late.close()


CLIENT = """([url, topics, protocols]) => new Promise((resolve, reject) => {
  const [reported, data] = [[], []];
  const socket = new WebSocket(url, protocols);
  socket.binaryType = "arraybuffer";
  const request = (command, speed) => {
    const message = new DataView(new ArrayBuffer(22));
    message.setUint8(0, 3); message.setUint8(1, command); message.setFloat32(2, speed, true);
    message.setUint32(15, 3, true); [97, 98, 99].forEach((letter, i) => message.setUint8(19 + i, letter));
    socket.send(message.buffer);
  };
  socket.onmessage = ({ data: message }) => {
    if (typeof message === "string") {
      const said = JSON.parse(message);
      reported.push(said);
      if (said.op !== "advertise") return;
      const wanted = said.channels.filter(({ topic }) => topics.includes(topic));
      socket.send(JSON.stringify({ op: "subscribe", subscriptions: wanted.map(({ id }, i) => ({ id: 100 + i, channelId: id })) }));
      if (socket.protocol === "foxglove.sdk.v1") request(0, 64);
    } else data.push(btoa(String.fromCharCode(...new Uint8Array(message))));
  };
  socket.onclose = () => resolve([reported, data, socket.protocol]);
  socket.onerror = () => reject(new Error("the socket failed"));
})"""


def test_foxglove_plays_a_run_while_another_client_is_stalled(browser, tmp_path):
    arguments = ["--stop-time", "20", "--workers", "2"]
    with Live(tmp_path, *arguments) as live:
        lines = [stalled(live.foxglove, "cosim.live.v1")]
        watching = browser.new_page()
        watching.goto(live.page)
        expect(status(watching, "state")).to_have_text("paused")
        page = browser.new_page()
        page.goto(live.page)
        # Before it, one of another program, which does not know the control.
        page.evaluate(f"url => {{ window.old = ({CLIENT})([url, ['/tf'], ['foxglove.websocket.v1']]); }}", live.foxglove)
        offered = ["foxglove.websocket.v1", "foxglove.sdk.v1"]
        reported, data, protocol = page.evaluate(CLIENT, [live.foxglove, ["/vehicle/odometry", "/dvl"], offered])
        old = page.evaluate("window.old")
        expect(status(watching, "state")).to_have_text("ended")
        watching.close()
        page.close()
        live.end()
        lines[0].close()
    assert protocol == "foxglove.sdk.v1"
    assert (tmp_path / "run.csv").read_bytes() == plain(tmp_path, "--stop-time", "20")

    old_info = next(said for said in old[0] if said["op"] == "serverInfo")
    assert (old[2], old_info["capabilities"]) == ("foxglove.websocket.v1", ["time"])
    assert {base64.b64decode(text)[0] for text in old[1]} == {1, 2}, "values and times, nothing else"
    info = next(said for said in reported if said["op"] == "serverInfo")
    assert {"time", "playbackControl"} <= set(info["capabilities"])
    assert (info["dataStartTime"], info["dataEndTime"]) == ({"sec": 0, "nsec": 0}, {"sec": 20, "nsec": 0})
    channels = {channel["topic"]: channel for said in reported if said["op"] == "advertise" for channel in said["channels"]}
    odometry = channels["/vehicle/odometry"]
    assert (odometry["encoding"], odometry["schemaEncoding"], odometry["schemaName"]) == ("cdr", "ros2msg", "nav_msgs/msg/Odometry")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(odometry["schema"], "nav_msgs/msg/Odometry"))

    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    names = header.split(",")
    recorded = {row.split(",")[0]: dict(zip(names, row.split(","))) for row in rows}
    messages = [base64.b64decode(text) for text in data]
    wanted = [topic for topic in channels if topic in ("/vehicle/odometry", "/dvl")]
    own = 100 + wanted.index("/vehicle/odometry")
    seen = 0
    for message in messages:
        if message[0] == 1 and struct.unpack_from("<I", message, 1)[0] == own:
            (time,) = struct.unpack_from("<Q", message, 5)
            position = store.deserialize_cdr(message[13:], "nav_msgs/msg/Odometry").pose.pose.position
            row = recorded[str(time / 1e9)]
            assert (position.x, position.y) == (float(row["vehicle.pose.y"]), float(row["vehicle.pose.x"]))
            seen += 1
    assert seen >= 10
    times = [struct.unpack_from("<Q", message, 1)[0] for message in messages if message[0] == 2]
    assert times == sorted(times) and len(times) > 0
    states = [message for message in messages if message[0] == 5]
    answer = next(message for message in states if message.endswith(b"abc"))
    status_byte, _, speed = struct.unpack_from("<BQf", answer, 1)
    assert (status_byte, speed) == (0, 64)
    assert states[-1][1] == 3, "the last message says that the data have ended"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_is_accessible(browser, tmp_path, scheme):
    with Live(tmp_path, "--stop-time", "5") as live:
        context = browser.new_context(color_scheme=scheme, viewport={"width": 400, "height": 800})
        page = context.new_page()
        page.goto(live.page)
        page.get_by_role("button", name="One step").click()
        expect(page.locator("#where")).to_contain_text("vehicle:")
        page.get_by_label("Signal", exact=True).fill("dvl.velocity.u")
        page.get_by_role("button", name="Show", exact=True).click()
        expect(page.get_by_role("button", name="Remove dvl.velocity.u")).to_be_visible()
        findings = Axe().run(page).response["violations"]
        assert [(finding["id"], finding["nodes"][0]["html"]) for finding in findings] == []
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
        context.close()


def test_what_cannot_be_is_refused(tmp_path):
    def refused(*arguments):
        done = subprocess.run([*map(str, [COSIM, *SYSTEM, *arguments])], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 2
        return done.stderr

    assert "--live" in refused("--paused")
    assert "--workers 1" in refused("--live", "--isolate")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        reported = refused(f"--live=127.0.0.1:{port}", "-o", "x.csv")
    assert f"127.0.0.1:{port}" in reported and "another port" in reported
    shutil.copy(ROOT / "examples" / "campaign" / "faults" / "stuck.toml", tmp_path / "run.injected.toml")
    assert "run.injected.toml" in refused("--live", "--scenario", "run.injected.toml", "-o", "run.csv")
