"""Metadata of the Zarr group of a run: its arrays, their axes and what they hold."""

from __future__ import annotations

import functools
import json
from typing import TYPE_CHECKING, Any, Final

from lostmotion.runs.blocks import ZSTD_LEVEL, pieces
from lostmotion.runs.job import order_of

if TYPE_CHECKING:
    from lostmotion.runs.job import Order

BLOCKS: Final = "blocks.zarr"


def zarr_metadata(order: Order) -> dict[str, bytes]:
    """Return the metadata of the Zarr group, by file. Made in memory, so that what is on disk is
    never believed. Kept for the next store of the same order.
    """
    return dict(_metadata(order.text()))


@functools.lru_cache(maxsize=4)
def _metadata(text: bytes) -> dict[str, bytes]:
    import zarr
    from zarr.codecs import ZstdCodec
    from zarr.storage import MemoryStore

    order, held = order_of(text), dict[str, Any]()
    about = {
        "lostmotion": order.made_with["lostmotion"],
        "arm": order.arm,
        "robots": order.robots,
        "visits": order.visits,
        "seed": order.seed,
    }
    group = zarr.create_group(
        MemoryStore(held), zarr_format=3, attributes={**about, "parts": list(order.parts)}
    )
    for name, piece in pieces(order).items():
        group.create_array(
            name,
            shape=(order.designs, order.blocks, *piece.shape),
            chunks=(1, 1, *piece.shape),
            dtype=piece.kind,
            fill_value=0,
            compressors=ZstdCodec(level=ZSTD_LEVEL, checksum=False),
            chunk_key_encoding={"name": "default", "separator": "."},
            dimension_names=("design", "block", *piece.axes),
            attributes={"long_name": piece.words},
        )
    return {f"{BLOCKS}/{name}": json_text(value.to_bytes()) for name, value in held.items()}


def json_text(raw: bytes) -> bytes:
    """Write JSON in one way, whatever the order of its keys was."""
    return (
        json.dumps(json.loads(raw), indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    ).encode()
