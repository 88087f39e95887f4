"""The live view: motion arrives, strangers are turned away, nothing is left behind."""

from __future__ import annotations

import asyncio
import gc
import json
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import Browser, Error
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.iostream import IOStream
from tornado.websocket import WebSocketClientConnection, WebSocketHandler, websocket_connect
from uncovered import without_coverage
from viewing_browser import Visit, until
from viewing_scenes import about_y, instants, pendulum, swarm, swing
from viewing_watcher import Watcher

from mecanique.errors import InputError
from mecanique.viewing.live.live import LiveView, read
from mecanique.viewing.scene.scene import SceneFrame

T = TypeVar("T")


@pytest.fixture
def view() -> Iterator[LiveView]:
    with LiveView(pendulum()) as started:
        yield started


def get(view: LiveView, path: str, **headers: str) -> tuple[int, str]:
    connection = HTTPConnection("127.0.0.1", urlsplit(view.url).port or 0, timeout=60)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


def connect(view: LiveView, **headers: str) -> Awaitable[WebSocketClientConnection]:
    address = view.url.replace("http:", "ws:") + "ws"
    return websocket_connect(HTTPRequest(address, headers=headers))


def origin(view: LiveView) -> str:
    return view.url.rsplit("/", 2)[0]


async def leave(link: WebSocketClientConnection) -> None:
    link.close()
    while await link.read_message() is not None:
        pass


def run(work: Coroutine[None, None, T]) -> T:
    """Run a coroutine in a thread of its own: the browser's driver keeps a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, asyncio.wait_for(work, 60)).result()


def in_background(action: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=action, daemon=True)
    thread.start()
    return thread


def test_motion_arrives_and_a_reload_restores_it(
    view: LiveView, visit: Callable[..., Visit]
) -> None:
    scene = pendulum()
    view.send(scene.frame(20))
    seen = visit(view.url)
    until(lambda: bool(seen.js("mecanique.clock.time") > 0))
    seen.settle()
    assert seen.body(1)[3:] == pytest.approx(scene.quaternions[20, 1], abs=1e-6)
    view.send(scene.frame(90))
    until(lambda: bool(seen.js("mecanique.clock.time") == pytest.approx(scene.t[90], rel=1e-6)))
    seen.settle()
    assert seen.body(1)[3:] == pytest.approx(scene.quaternions[90, 1], abs=1e-6)
    seen.page.reload()
    seen.page.wait_for_selector("body.ready")
    until(lambda: bool(seen.js("mecanique.clock.time") == pytest.approx(scene.t[90], rel=1e-6)))
    seen.settle()
    assert seen.body(1)[3:] == pytest.approx(scene.quaternions[90, 1], abs=1e-6)
    assert seen.messages == []
    assert seen.errors == []
    assert all(urlsplit(address).netloc == urlsplit(view.url).netloc for address in seen.requests)


BUILT_SLOWLY = """
const bytes = Response.prototype.arrayBuffer;
Response.prototype.arrayBuffer = async function () {
  await new Promise((done) => setTimeout(done, 400));
  return bytes.call(this);
};
"""
"""What the page holds takes its time to unpack."""


def test_what_the_server_says_while_a_page_is_built_is_not_lost(
    view: LiveView, browser: Browser
) -> None:
    view.warn("the program has an error")
    with browser.new_context(reduced_motion="reduce") as context:
        context.add_init_script(BUILT_SLOWLY)
        page = context.new_page()
        page.goto(view.url)
        page.wait_for_selector("#alarm:not([hidden])", timeout=60_000)
        assert page.inner_text("#alarm") == "the program has an error"


def test_a_turned_camera_and_the_open_tab_outlive_another_scene(
    view: LiveView, visit: Callable[..., Visit]
) -> None:
    seen = visit(view.url)
    until(lambda: view.viewers == 1)
    seen.page.select_option("#follow", "")
    seen.js(
        """() => {
            const { camera, stage: { three: { Vector3 } } } = mecanique;
            camera.chosen(null);
            camera.place(new Vector3(0.5, 0.25, -1), new Vector3(4, 5, 6));
        }"""
    )
    seen.page.click("#tab-plots")
    view.show(replace(pendulum(), title="Another pendulum"))
    seen.page.wait_for_selector("h1:has-text('Another pendulum')")
    seen.page.wait_for_selector("body.ready")
    camera = "[...mecanique.camera.center().toArray(), ...mecanique.camera.eye().toArray()]"
    assert seen.js(camera) == pytest.approx([0.5, 0.25, -1, 4, 5, 6], abs=1e-9)
    assert seen.page.get_attribute("#tab-plots", "aria-selected") == "true"
    assert seen.js("document.querySelectorAll('[data-camera][aria-pressed=true]').length") == 0
    assert seen.page.input_value("#follow") == ""
    assert seen.errors == []


def test_two_pages_see_the_same_and_steer_it(view: LiveView, visit: Callable[..., Visit]) -> None:
    scene = pendulum(duration=60.0)
    streaming = in_background(lambda: view.stream(lambda _: instants(scene), speed=0.5, hold=True))
    one, two = visit(view.url), visit(view.url)
    until(lambda: view.viewers == 2 and bool(two.js("mecanique.clock.time") > 0.05))
    one.page.click("#play")
    until(lambda: two.js("mecanique.clock.playing") is False)
    until(lambda: bool(one.js("mecanique.clock.time") == two.js("mecanique.clock.time")))
    two.settle()
    # at once, because a picture may still be on its way
    paused, x, y, z, w = two.js(
        "[mecanique.clock.time, ...mecanique.stage.nodes[1].quaternion.toArray()]"
    )
    assert [x, y, z, w] == pytest.approx(about_y(swing(np.array([paused]), 2.0)[0])[0], abs=1e-6)
    two.page.select_option("#speed", "2")
    two.page.click("#play")
    until(lambda: bool(one.js("mecanique.clock.time") > paused + 0.3))
    assert one.page.input_value("#speed") == "2"
    view.close()
    streaming.join(60)
    assert not streaming.is_alive()
    one.page.wait_for_selector("#notice:not([hidden])")


def test_a_dragged_parameter_starts_the_motion_again(
    view: LiveView, visit: Callable[..., Visit]
) -> None:
    calls: list[Mapping[tuple[str, str], float]] = []

    def frames(changes: Mapping[tuple[str, str], float]) -> Iterator[SceneFrame]:
        calls.append(changes)
        return instants(pendulum())

    streaming = in_background(lambda: view.stream(frames, hold=True))
    seen = visit(view.url)
    seen.page.click("#tab-parameters")
    until(lambda: bool(seen.js("mecanique.clock.time") > 0.2))
    seen.js(
        """() => {
            const slider = document.querySelector('[data-name=l]');
            slider.value = 1.5;
            slider.oninput();
            slider.onchange();
        }"""
    )
    until(lambda: len(calls) == 2)
    assert calls == [{}, {("parameter", "l"): 1.5}]
    view.close()
    streaming.join(60)
    assert not streaming.is_alive()


def test_an_open_page_finds_the_server_that_came_back(visit: Callable[..., Visit]) -> None:
    scene = pendulum()
    first = LiveView(scene, token="remembered-token")
    port = urlsplit(first.url).port or 0
    seen = visit(first.url)
    first.close()
    seen.page.wait_for_selector("#notice:not([hidden])")
    with LiveView(scene, port=port, token="remembered-token") as again:
        again.send(scene.frame(30))
        until(lambda: again.viewers == 1)
        seen.page.wait_for_selector("body.ready")
        until(
            lambda: bool(
                asked(seen, "window.mecanique?.clock.time") == pytest.approx(0.5, rel=1e-6)
            )
        )


def test_an_open_page_survives_a_program_that_is_killed(
    tmp_path: Path, visit: Callable[..., Visit]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    script = tmp_path / "show.py"
    script.write_text(
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from viewing_scenes import instants, pendulum\n"
        "from mecanique.viewing.live.live import LiveView\n"
        f"with LiveView(pendulum(duration=0.5), port={port}, token='remembered-token') as view:\n"
        "    print(view.url, flush=True)\n"
        "    view.stream(lambda _: instants(view.scene), hold=True)\n",
        encoding="utf-8",
    )

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, str(script)], stdout=subprocess.PIPE, encoding="utf-8"
        )

    with start() as first:
        assert first.stdout is not None
        seen = visit(first.stdout.readline().strip())
        until(lambda: bool(seen.js("mecanique.clock.time") > 0.1))
        gone = seen.js("mecanique.scene.live.id")
        first.kill()
    seen.page.wait_for_selector("#notice:not([hidden])")
    with start() as again:
        try:
            until(lambda: identity(seen) not in (None, gone))
            until(lambda: (asked(seen, "window.mecanique?.clock.time") or 0.0) > 0.1)
            until(seen.page.locator("#notice").is_hidden)
        finally:
            again.kill()


def identity(seen: Visit) -> Any:
    """Which scene the page shows; None while it loads."""
    return asked(seen, "window.mecanique?.scene.live.id ?? null")


def asked(seen: Visit, script: str) -> Any:
    """What a script gives; None if the page changes while it is asked."""
    try:
        return seen.js(script)
    except Error:
        return None


def test_strangers_are_turned_away(view: LiveView) -> None:
    path = urlsplit(view.url).path
    assert get(view, path)[0] == 200
    assert get(view, path, Host="evil.example")[0] == 403
    assert get(view, path, Host=f"127.0.0.1.evil.example:{urlsplit(view.url).port}")[0] == 403
    assert get(view, "/")[0] == 404
    assert get(view, "/guess/")[0] == 404
    assert get(view, path[:-2] + "/")[0] == 404
    assert get(view, path + "x")[0] == 404
    assert get(view, path + "../")[0] == 404

    async def codes() -> list[int]:
        found = []
        tries: tuple[dict[str, str], ...] = (
            {},
            {"Origin": "http://evil.example"},
            {"Origin": "null"},
            {"Origin": origin(view).replace("http:", "https:")},
            {"Origin": "http://evil.example", "Host": "evil.example"},
            {"Origin": "http://evil.example", "Sec-Fetch-Site": "same-origin"},
        )
        for headers in tries:
            with pytest.raises(HTTPClientError) as refusal:
                await connect(view, **headers)
            found.append(refusal.value.code)
        await leave(await connect(view, Origin=origin(view)))
        return found

    assert run(codes()) == [403] * 6


def test_it_listens_on_the_loopback_only(view: LiveView) -> None:
    assert urlsplit(view.url).hostname == "127.0.0.1"
    assert view._server._socket.getsockname() == ("127.0.0.1", urlsplit(view.url).port)


def test_it_is_gone_after_close() -> None:
    before = threading.active_count()
    view = LiveView(pendulum())
    port = urlsplit(view.url).port or 0
    assert get(view, urlsplit(view.url).path)[0] == 200
    view.close()
    view.close()
    with pytest.raises(ConnectionRefusedError):
        get(view, "/")
    assert threading.active_count() == before
    LiveView(pendulum(), port=port).close()


def test_control_c_ends_it_and_leaves_nothing(tmp_path: Path) -> None:
    script = tmp_path / "show.py"
    script.write_text(
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from viewing_scenes import instants, pendulum\n"
        "from mecanique.viewing.live.live import LiveView\n"
        "with LiveView(pendulum(duration=0.5)) as view:\n"
        "    print(view.url, flush=True)\n"
        "    view.stream(lambda _: instants(view.scene), hold=True)\n",
        encoding="utf-8",
    )
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        env=without_coverage(),
    ) as run:
        assert run.stdout is not None
        address = urlsplit(run.stdout.readline().strip())
        time.sleep(0.2)
        run.send_signal(signal.SIGINT)
        _, complaint = run.communicate(timeout=60)
    assert complaint.rstrip().endswith("KeyboardInterrupt")
    assert complaint.count("Traceback") == 1
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", address.port or 0), timeout=60)


def test_a_taken_port_is_named(view: LiveView) -> None:
    with pytest.raises(InputError, match=r"port \d+ of 127.0.0.1: .*expected a free one, or 0"):
        LiveView(pendulum(), port=urlsplit(view.url).port or 0)
    with pytest.raises(InputError, match=r"token of a live view"):
        LiveView(pendulum(), token="../../")


def test_a_slow_page_is_sent_every_place_of_the_traces() -> None:
    scene = pendulum(1.0)
    with LiveView(scene) as view, Watcher(view.url, pause=0.05) as watcher:
        watcher.until(lambda seen: bool(seen.times))
        for k in range(1, len(scene.t)):
            view.send(scene.frame(k))
        watcher.reach(float(scene.t[-1]))
        shown, passed = watcher.times, np.concatenate(watcher.passed)
    assert len(shown) < 10
    between = [k for k, t in enumerate(scene.t) if t not in shown]
    assert passed == pytest.approx(scene.traces[0].points[between].ravel(), abs=1e-6)


def test_a_slow_page_is_sent_only_the_latest_frame() -> None:
    scene = swarm(100, 1.0)
    frames = [scene.frame(k % len(scene.t)) for k in range(300)]
    with LiveView(scene) as view:

        async def watch() -> tuple[list[int], int]:
            link = await connect(view, Origin=origin(view))
            assert json.loads(str(await link.read_message()))["paused"] is False
            numbers = [number(await link.read_message())]
            start = time.thread_time()
            for frame in frames:
                view.send(frame)
            spent = time.thread_time() - start
            assert spent < len(frames) / 60, "60 frames a second of 100 bodies"
            await asyncio.sleep(0.1)
            while numbers[-1] <= len(frames):
                numbers.append(number(await link.read_message()))
                await link.write_message(json.dumps({"do": "ack", "value": numbers[-1]}))
            await leave(link)
            return numbers, view._server._number

        numbers, last = run(watch())
    assert numbers[0] == 1
    assert numbers[-1] == last == 301
    # one frame may be under way while the others come; a busy machine may send only the last
    assert len(numbers) <= 3


def number(message: str | bytes | None) -> int:
    assert isinstance(message, bytes)
    return int(struct.unpack_from("<I", message)[0])


def test_streams_keep_real_time() -> None:
    """Other work on the machine can only make a stream longer: the shortest of some tells."""
    scene = pendulum(duration=0.6)

    def shortest(show: Callable[[], object]) -> float:
        taken = []
        for _ in range(5):
            start = time.monotonic()
            show()
            taken.append(time.monotonic() - start)
        return min(taken)

    with LiveView(scene) as view:
        for speed in (1.0, 3.0):

            def play(rate: float = speed) -> None:
                view.stream(instants(scene), speed=rate)

            taken = shortest(play)
            assert taken == pytest.approx(0.6 / speed, abs=0.08)


def test_a_page_that_goes_away_while_it_is_written_to_is_let_go() -> None:
    """Its connection is reset with more under way than the operating system takes."""
    complaints: list[dict[str, Any]] = []
    with LiveView(pendulum()) as view:
        loop = view._server._loop
        loop.call_soon_threadsafe(
            loop.set_exception_handler, lambda _, context: complaints.append(context)
        )
        with shaken_hands(view) as link:
            until(lambda: view.viewers == 1)
            (stream,) = map(stream_of, view._server.clients)
            view.warn("x" * 20_000_000)
            until(stream.writing)
            link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        until(lambda: view.viewers == 0)
        again = run(opened(view))
    gc.collect()
    assert again
    assert complaints == []


def shaken_hands(view: LiveView) -> socket.socket:
    """Return a connection that is a websocket, and is never read."""
    address = urlsplit(view.url)
    link = socket.create_connection(("127.0.0.1", address.port or 0), timeout=60)
    request = (
        f"GET {address.path}ws HTTP/1.1\r\nHost: {address.netloc}\r\nOrigin: {origin(view)}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    link.sendall(request.encode())
    return link


def stream_of(page: WebSocketHandler) -> IOStream:
    assert page.ws_connection is not None
    stream = page.ws_connection.stream
    assert isinstance(stream, IOStream)
    return stream


async def opened(view: LiveView) -> bool:
    """Whether another page is served as before."""
    link = await connect(view, Origin=origin(view))
    state = json.loads(str(await link.read_message()))
    await leave(link)
    return "scene" in state


def test_a_frame_must_fit_the_scene(view: LiveView) -> None:
    with pytest.raises(InputError, match=r"row of a frame: expected shape \(\d+,\), got \(\d+,\)"):
        view.send(swarm(3, 0.1).frame(0))


@pytest.mark.parametrize(
    "text",
    [
        b"bytes",
        "",
        "[]",
        "{}",
        '{"do": "eval"}',
        '{"do": []}',
        '{"do": "pause", "more": 1}',
        '{"do": "speed", "value": "1"}',
        '{"do": "speed", "value": NaN}',
        '{"do": "speed", "value": 0}',
        '{"do": "speed", "value": true}',
        '{"do": "seek", "value": 1}',
        '{"do": "ack", "value": 1' + "0" * 400 + "}",
        '{"do": "parameter", "name": 3, "value": 1}',
        '{"do": "ack", "value": 1}' + " " * 600,
        "[" * 400,
    ],
)
def test_what_a_page_does_not_send_is_not_read(text: str | bytes) -> None:
    assert read(text) is None


def test_what_a_page_sends_is_read() -> None:
    assert read('{"do": "pause"}') == {"do": "pause"}
    assert read('{"do": "initial", "name": "theta", "value": -2}') == {
        "do": "initial",
        "name": "theta",
        "value": -2,
    }
