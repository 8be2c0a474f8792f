"""Pictures of a viewport, made beside Blender: a coarse one at once, then the sharp one; a new edit stops them."""

import threading
from dataclasses import replace

from . import camera, picture
from .notes import Refused

#: The first picture has so many times fewer pixels along each side.
COARSE = 4


class _Stopped(Exception):
    """There is something newer to show."""


class Worker:
    """Renders what a viewport shows. Only Blender's thread edits, and only while nothing is rendered."""

    def __init__(self, engine, exporter, live, divisors=(COARSE, 1)):
        self._engine, self._exporter, self._live = engine, exporter, live
        self._divisors = divisors
        self._thread = None
        self._stop = threading.Event()
        self._shown = None
        self._view = None
        self._is_new = True
        self.message = ""

    def stop(self):
        """Stops rendering, and waits until it has stopped."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self._stop.clear()

    def update(self, context, depsgraph, touched):
        """Takes the changes of a scene over."""
        self.stop()
        if self._is_new:
            touched = type(touched)()
        self._snapshot = self._exporter.snapshot(depsgraph, touched, context.space_data)
        self._is_new = False
        # Shown at the next draw, which knows the view.
        self._view = None

    def picture(self, context, depsgraph):
        """The newest picture of the viewport; starts a newer one where the view or the scene has changed."""
        region = context.region
        try:
            view = camera.of_viewport(context.region_data.window_matrix, context.region_data.view_matrix, (region.width, region.height))
            if view != self._view:
                self.stop()
                self._start(view, depsgraph.scene)
        except Exception as error:
            self._view, self._shown = None, None
            self.message = _line(error)
        return self._shown

    def _start(self, view, scene):
        from .engine import engine_settings

        if self._view is None:
            self._live.show(self._snapshot, view, engine_settings(scene, is_viewport=True))
        self._view = view
        self.message = "; ".join(self._live.notes.lines)
        self._thread = threading.Thread(target=self._run, args=(view, scene.render.film_transparent), daemon=True)
        self._thread.start()

    def _run(self, view, is_transparent):
        def progress(_stage, _done):
            if self._stop.is_set():
                raise _Stopped

        try:
            for divisor in self._divisors:
                smaller = reduced(view, divisor)
                self._live.look(smaller)
                made = picture.render(self._live, smaller, is_transparent=is_transparent, progress=progress)
                self._shown = made
                self._redraw()
        except _Stopped:
            pass
        except Exception as error:
            self.message = _line(error)
            self._redraw()

    def _redraw(self):
        try:
            self._engine.tag_redraw()
        except ReferenceError:
            # The viewport is closed.
            self._stop.set()


def _line(error):
    """An error as a line: the scene's own are meant for people, others name their kind."""
    return str(error) if isinstance(error, Refused) else f"{type(error).__name__}: {error}"


def reduced(view, divisor):
    """The view with fewer pixels; its window may cover up to a coarse pixel more."""
    if divisor == 1:
        return view
    frame = tuple(max(1, -(-side // divisor)) for side in view.frame)
    x, y, width, height = view.window
    left, top = x // divisor, y // divisor
    right, low = -(-(x + width) // divisor), -(-(y + height) // divisor)
    return replace(view, frame=frame, window=(left, top, right - left, low - top))
