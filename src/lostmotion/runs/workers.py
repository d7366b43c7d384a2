"""Who computes the blocks: threads of this process, or the workers of a Dask cluster. They hand
back bytes; only the caller writes.
"""

from __future__ import annotations

import importlib.util
import logging
from collections import deque
from collections.abc import Callable  # noqa: TC003 - read by the named tuple
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from lostmotion.errors import InputError, LostmotionError, Problem, refuse_argument, shown
from lostmotion.runs.blocks import compute_packed

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from concurrent.futures import Future

    Packed = dict[str, bytes]
    Done = tuple[int, int, Packed, dict[str, str]]

# Blocks handed out for each worker at a time: enough to keep it busy, few enough to bound what
# waits in memory.
_AHEAD: Final = 2
_LOCAL: Final = "local:"
_MOST_LOCAL: Final = 1024
# A scheduler that is there answers within one.
_SECONDS_TO_CONNECT: Final = 5


class Cluster(NamedTuple):
    """A Dask cluster that answered: its client, and how many threads its workers have by now."""

    client: Any
    workers: Callable[[], int]


def on_threads(text: bytes, todo: Iterable[tuple[int, int]], workers: int) -> Iterator[Done]:
    """Compute these blocks of an order on threads, and hand each on with the versions that made it,
    in the order asked for.
    """
    pool = ThreadPoolExecutor(workers)
    waiting: deque[tuple[int, int, Future[tuple[Packed, dict[str, str]]]]] = deque()
    try:
        for design, block in todo:
            waiting.append((design, block, pool.submit(compute_packed, text, design, block)))
            if len(waiting) >= _AHEAD * workers:
                first, second, future = waiting.popleft()
                yield first, second, *future.result()
        while waiting:
            first, second, future = waiting.popleft()
            yield first, second, *future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def check_address(address: str) -> None:
    """Refuse what cannot be an address, and an address where Dask is not installed, before anything
    is written.
    """
    if _local_workers(address) is None and ":" not in address:
        raise refuse_argument(
            "dask",
            address,
            "local:N with N worker processes, or the address of a scheduler",
            dask="tcp://10.0.0.5:8786",
        )
    if importlib.util.find_spec("distributed") is None:
        raise LostmotionError(
            "--dask needs Dask, which is not installed\n  pip install 'lostmotion[dask]'"
        )


def on_dask(text: bytes, todo: Iterable[tuple[int, int]], cluster: Cluster) -> Iterator[Done]:
    """Compute these blocks of an order on a Dask cluster, and hand each on as it comes.

    A block whose worker dies is computed by another. Raises LostmotionError where the scheduler
    goes, or one block's workers die again and again.
    """
    from distributed import as_completed

    client, workers = cluster
    rest = iter(todo)
    at = {}

    def hand_out() -> Iterator[Any]:
        for design, block in rest:
            # The text goes along every time: what is scattered is lost with its worker, and nobody
            # could compute it again.
            future = client.submit(compute_packed, text, design, block, pure=False)
            at[future.key] = (design, block)
            yield future
            if len(at) >= _AHEAD * max(workers(), 1):
                return

    # A scheduler that dies is noticed by whichever call asks it next: for its workers, to hand a
    # block out, or for a result.
    with _gone_in_one_message():
        running = as_completed(list(hand_out()), loop=client.loop)
    for future in _one_by_one(running):
        packed, versions = _result(future)
        yield *at.pop(future.key), packed, versions
        with _gone_in_one_message():
            future.release()
            running.update(list(hand_out()))


def _one_by_one(running: Iterable[Any]) -> Iterator[Any]:
    """Return what is done as it comes; raises LostmotionError where nothing comes any more."""
    each = iter(running)
    while True:
        with _gone_in_one_message():
            future = next(each, None)
        if future is None:
            return
        yield future


@contextmanager
def _gone_in_one_message() -> Iterator[None]:
    """Report in one message that the scheduler is gone, whatever Dask calls that."""
    from asyncio import CancelledError as Cancelled
    from concurrent.futures import CancelledError

    try:
        yield
    except (CancelledError, Cancelled, OSError, TimeoutError, RuntimeError) as error:
        message = f"the Dask scheduler is gone ({type(error).__name__}: {shown(error)})"
        raise LostmotionError(
            f"{message}\n  finished blocks are stored; the same command resumes"
        ) from error


def _result(future: Any) -> tuple[dict[str, bytes], dict[str, str]]:  # noqa: ANN401 - Dask publishes no types
    from distributed import KilledWorker

    try:
        with _gone_in_one_message():
            packed, versions = future.result()
    except KilledWorker as error:
        raise LostmotionError(
            f"the workers of one block died again and again: {error}\n  look at their memory; "
            "the same command goes on"
        ) from error
    return packed, versions


@contextmanager
def cluster(address: str) -> Iterator[Cluster]:
    """Connect to the scheduler at this address, or with `local:N` start a cluster on this machine
    that nobody else can reach.

    Raises InputError for an address that is none, or at which no scheduler answers within seconds;
    LostmotionError where Dask is not installed.
    """
    local = _local_workers(address)
    check_address(address)
    from distributed import Client, LocalCluster
    from distributed.comm import resolve_address

    _silence_logs()

    if local is None:
        try:
            resolve_address(address)  # an impossible scheme or host is reported at once
            client = Client(address, timeout=_SECONDS_TO_CONNECT, set_as_default=False)
        except (OSError, ValueError, OverflowError, ImportError) as error:
            found = f"{shown(address)}: no Dask scheduler answers there ({shown(error)})"
            raise InputError(
                [
                    Problem(
                        "",
                        "dask",
                        found,
                        "the address of a running scheduler, or local:N",
                        passing=(("dask", "tcp://10.0.0.5:8786"),),
                    )
                ]
            ) from None
        with client:
            yield Cluster(client, lambda: sum(client.nthreads().values()))
        return
    with (
        LocalCluster(
            n_workers=local,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield Cluster(client, lambda: local)


def _silence_logs() -> None:
    """Keep Dask from logging tracebacks of its own where a scheduler or a worker dies: one message
    says so.
    """
    for name in ("distributed", "tornado", "asyncio", *list(logging.root.manager.loggerDict)):
        if name.partition(".")[0] in {"distributed", "tornado", "asyncio"}:
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _local_workers(address: str) -> int | None:
    if not address.startswith("local"):
        return None
    count = address.removeprefix(_LOCAL)
    if not count.isdecimal() or not 1 <= int(count) <= _MOST_LOCAL:
        raise refuse_argument(
            "dask",
            address,
            "local:N with N worker processes, or the address of a scheduler",
            dask="local:4",
        )
    return int(count)
