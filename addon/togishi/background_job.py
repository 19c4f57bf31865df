"""Work of the native module in a thread of its own, beside the user interface, with progress and cancel. It needs no
Blender data: what it starts from is copied when it is made."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

from .core import native


class BackgroundJob:
    """One piece of work. A kind of work has its own _compute(), and a name for its thread."""

    thread_name = "togishi"

    def __init__(self) -> None:
        self._core = native.core()
        self.share = 0.0  # of the work that is done
        self.cancelled = False
        self._result: Any = None
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=self.thread_name, daemon=True)

    def _compute(self) -> Any:
        """The work itself, in the thread; hands _progress to the native module."""
        raise NotImplementedError

    def _progress(self, share: float) -> bool:
        self.share = share
        return not self.cancelled

    def _run(self) -> None:
        try:
            self._result = self._compute()
        except Exception as error:  # handed to the main thread, which raises it again
            self._error = error
        finally:
            _running.discard(self)

    def start(self) -> None:
        _running.add(self)
        self._thread.start()

    def cancel(self) -> None:
        """End it at its next report of progress. There is no result then."""
        self.cancelled = True

    def wait(self) -> None:
        self._thread.join()

    @property
    def done(self) -> bool:
        return not self._thread.is_alive()

    def result(self) -> Any:
        """What _compute() returned; waits for it. Raises what it raised; InterruptedError after cancel()."""
        self.wait()
        if self._error is not None:
            raise self._error
        return self._result


_running: set[BackgroundJob] = set()


def running() -> Iterator[BackgroundJob]:
    """Jobs under way that nobody cancelled."""
    return (job for job in list(_running) if not job.cancelled)


def stop_all() -> None:
    """Cancel what runs and wait for it: no thread outlives the add-on, or Blender."""
    for job in list(_running):
        job.cancel()
        job.wait()
