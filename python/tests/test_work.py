"""Threads, lifetimes, signals, progress, memory and pickles."""

import copy
import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import cosine_lobes as cl
from conftest import cube, stage


def slow_renderer():
    """One whose pictures take a second or more."""
    return cl.Renderer(stage(size=(960, 640)), tolerance=0.001, depth=6, samples=64, keep_points=False, visibility="rays")


def test_threads_with_renderers_of_their_own(scene):
    want = cl.Renderer(scene).render()
    pictures = {}

    def work(number):
        renderer = cl.Renderer(scene)
        pictures[number] = [renderer.render() for _ in range(5)]

    threads = [threading.Thread(target=work, args=(number,)) for number in range(6)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(pictures) == 6
    assert all(np.array_equal(picture, want) for each in pictures.values() for picture in each)


def test_threads_that_share_a_renderer(scene):
    renderer = cl.Renderer(scene)
    here = renderer.light(0)
    wanted = {}
    for place in range(4):
        renderer.set_light(0, here.shifted((place, 0, 0)))
        wanted[place] = renderer.render()
    faults = []

    def work(place):
        for _ in range(5):
            renderer.set_light(0, here.shifted((place, 0, 0)))
            picture = renderer.render()
            # Another thread may have moved the light in between.
            if not any(np.array_equal(picture, want) for want in wanted.values()):
                faults.append(place)

    threads = [threading.Thread(target=work, args=(place,)) for place in wanted]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert not faults


def test_the_interpreter_runs_beside_a_picture():
    renderer = slow_renderer()
    count, is_done = 0, threading.Event()

    def work():
        with pytest.raises(KeyError):
            renderer.render(progress=stop)
        is_done.set()

    def stop(stage, done):
        if count > 20:
            raise KeyError

    thread = threading.Thread(target=work)
    thread.start()
    while not is_done.is_set():
        count += 1
        time.sleep(0.001)
    thread.join()
    assert count > 20


def test_arrays_outlive_the_renderer(scene):
    renderer = cl.Renderer(scene)
    picture, layers = renderer.render(), renderer.layers()
    copies = picture.copy(), {name: layer.copy() for name, layer in layers.items()}
    light, objects = renderer.light(0), renderer.objects
    del renderer, scene
    gc.collect()
    junk = [np.full(picture.shape, 7, np.float32) for _ in range(20)]
    assert np.array_equal(picture, copies[0])
    assert all(np.array_equal(layers[name], copies[1][name]) for name in layers)
    assert light.kind == "sphere" and len(objects) == 3 and junk
    picture[:] = 0
    assert picture.flags.c_contiguous and picture.flags.writeable


def test_pictures_do_not_share_memory(scene):
    renderer = cl.Renderer(scene)
    first, second = renderer.render(), renderer.render()
    assert np.array_equal(first, second) and not np.shares_memory(first, second)
    first[:] = 5
    assert np.array_equal(renderer.render(), second)


def test_pictures_into_the_caller_s_memory(scene):
    renderer = cl.Renderer(scene)
    want = renderer.render()
    frames = np.zeros((3, 32, 48, 3), np.float32)
    for frame in frames:
        assert renderer.render(out=frame) is frame
    assert (frames == want).all()


@pytest.mark.parametrize(
    "out, fault",
    [
        (np.zeros((32, 48, 3)), "out has dtype float64: expected float32"),
        (np.zeros((48, 32, 3), np.float32), r"out has shape \(48, 32, 3\): expected \(32, 48, 3\)"),
        (np.zeros((32, 48), np.float32), r"out has shape \(32, 48\): expected \(32, 48, 3\)"),
        (np.zeros((32, 48, 4), np.float32)[..., :3], r"out has strides \[768, 16, 4\]: expected rows in order, without gaps"),
        (np.asfortranarray(np.zeros((32, 48, 3), np.float32)), "out has strides"),
        (np.broadcast_to(np.float32(0), (32, 48, 3)), "out has strides"),
        (np.frombuffer(bytes(4 * 32 * 48 * 3), np.float32).reshape(32, 48, 3), "out: .*not writeable"),
        ([], "out is of type list: expected a numpy array of float32"),
    ],
    ids=["dtype", "shape", "dimensions", "gaps", "columns", "broadcast", "read-only", "list"],
)
def test_wrong_memory_is_refused(scene, out, fault):
    with pytest.raises((TypeError, ValueError), match=fault):
        cl.Renderer(scene).render(out=out)


def test_progress(scene):
    heard = []
    # More rays than are shaded at once; they meet nothing, which costs little.
    scene.camera = cl.Camera((0, 2, 0), (0, 9, 1))
    scene.size = (1100, 1000)
    renderer = cl.Renderer(scene, samples=1)
    renderer.render(progress=lambda stage, done: heard.append((stage, done, threading.get_ident())))
    shading = [done for stage, done, _ in heard if stage == "shading"]
    assert len(shading) > 2 and shading == sorted(shading) and shading[0] == 0 < shading[-1] < 1
    assert {ident for *_, ident in heard} == {threading.get_ident()}


def test_a_callback_that_raises_stops_the_picture(scene):
    renderer = cl.Renderer(scene)
    want = renderer.render()

    def stop(stage, done):
        raise ZeroDivisionError("enough")

    with pytest.raises(ZeroDivisionError, match="enough"):
        renderer.render(progress=stop)
    assert np.array_equal(renderer.render(), want)


def test_a_callback_cannot_use_its_renderer(scene):
    renderer = cl.Renderer(scene)
    want = renderer.render()
    with pytest.raises(cl.RenderError, match="the renderer is at work: a callback of it cannot use it"):
        renderer.render(progress=lambda stage, done: renderer.size)
    assert np.array_equal(renderer.render(), want)


@pytest.fixture
def ctrl_c():
    """Ctrl-C as a terminal has it: shells start jobs in the background without."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_stops_a_picture():
    renderer = slow_renderer()
    main = threading.main_thread().ident
    for call in (renderer.render, renderer.layers, renderer.unshadowed):
        start = time.monotonic()
        timer = threading.Timer(0.2, lambda: signal.pthread_kill(main, signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            call()
        assert time.monotonic() - start < 5
        timer.join()
    # Nothing is broken by it.
    renderer.set_size(16, 8)
    renderer.set_settings(samples=1)
    assert np.array_equal(renderer.render(), renderer.render())


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_stops_a_reference_and_a_fit():
    main = threading.main_thread().ident
    for call in (lambda: cl.reference(stage(), spp=1 << 20), lambda: cl.SphereSet.fit(*cube(), count=40)):
        timer = threading.Timer(0.2, lambda: signal.pthread_kill(main, signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            call()
        timer.join()


def test_settings_are_pickled_and_compared():
    settings = cl.Settings(tolerance=0.01, visibility="rays", samples=4, cache="/tmp/kept", threshold=0.1)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(settings, protocol))
        assert again == settings and again.asdict() == settings.asdict()
    assert copy.deepcopy(settings) == settings == copy.copy(settings)
    assert settings.replace(samples=1) != settings and settings.replace(samples=1).tolerance == 0.01
    assert cl.Settings(**settings.asdict()) == settings
    no_cache = cl.Settings(cache=False)
    assert no_cache.cache is None and pickle.loads(pickle.dumps(no_cache)) == no_cache
    assert eval(repr(cl.Settings(cache=False)), {"Settings": cl.Settings}) == no_cache  # noqa: S307
    with pytest.raises(AttributeError):
        settings.tolerance = 0.5


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_gets_an_error_instead_of_waiting(scene):
    renderer = cl.Renderer(scene)
    renderer.render()
    child = os.fork()
    if child == 0:
        caught = 0
        for work in (renderer.render, lambda: cl.Renderer(scene).render(), lambda: cl.reference(scene, spp=8)):
            try:
                work()
            except cl.RenderError as error:
                caught += "forked" in str(error)
        os._exit(7 if caught == 3 else 8)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_a_process_ends_while_it_renders(tmp_path):
    """A daemon thread that renders does not keep the interpreter, nor crash it."""
    text = f"""
import sys, threading, time
sys.path[:0] = {sys.path!r}
from test_work import slow_renderer
threading.Thread(target=slow_renderer().render, daemon=True).start()
time.sleep(0.2)
"""
    done = subprocess.run([sys.executable, "-c", text], check=False, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
