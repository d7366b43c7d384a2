"""The product of a Monte Carlo study: |bias + sum over terms of screw x draw|^2 for sixteen robots
at once.

It is written as vector instructions, because the compiler's own loops keep the sums in memory. Here
the three components of sixteen robots stay in twelve registers of four numbers, or six of eight,
and the processor does little else than multiply and add. A fused multiply-add rounds once by
definition, also where it is emulated in software, so the bits depend neither on the processor nor
on the width of its registers.
"""

from __future__ import annotations

from typing import Final

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from lostmotion.compiled import compiled

AT_ONCE: Final = 16
# Numbers per register: eight with AVX-512. The compiler would split longer vectors and keep sums in
# memory.
_WIDE: Final = 8 if binding.get_host_cpu_features().get("avx512f") else 4
_PARTS: Final = AT_ONCE // _WIDE
# Robots at a time; their draws leave enough of the first-level cache for all other data.
_STEP: Final = 64


@intrinsic
def fma(_typing, a, b, c):
    """Return a b + c, rounded once."""
    del a, b, c

    def written(_context, builder, _signature, numbers):
        return builder.fma(*numbers)

    return types.float64(types.float64, types.float64, types.float64), written


@intrinsic
def _squares_of_sixteen(_typing, terms, screws, draws, bias, pose, lane, out):
    """Write |bias + sum_t screws[t] draws_t[lane + i]|^2 of one pose to out[pose, lane + i], i = 0
    … 15, over the first `terms` >= 1 terms.
    """
    if any(array.layout != "C" for array in (screws, draws, bias, out)):
        return None
    signature = types.void(terms, screws, draws, bias, pose, lane, out)

    def written(context, builder, signature, values):
        real, index = ir.DoubleType(), ir.IntType(64)
        vector = ir.VectorType(real, _WIDE)
        arrays = [make_array(signature.args[k])(context, builder, values[k]) for k in (1, 2, 3, 6)]
        terms, pose, lane = values[0], values[4], values[5]
        fused = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fma.v{_WIDE}f64"
        )

        def at(pointer, offset):
            return builder.gep(pointer, [offset if isinstance(offset, ir.Value) else index(offset)])

        def of_pose(array):
            """Return the address of this pose's data: each pose before it has as many numbers as
            the other axes together.
            """
            begin = pose
            for length in cgutils.unpack_tuple(builder, array.shape)[1:]:
                begin = builder.mul(begin, length)
            return at(array.data, begin)

        def in_all_lanes(pointer):
            one = builder.insert_element(
                ir.Constant(vector, ir.Undefined), builder.load(pointer), ir.IntType(32)(0)
            )
            return builder.shuffle_vector(
                one,
                ir.Constant(vector, ir.Undefined),
                ir.Constant(ir.VectorType(ir.IntType(32), _WIDE), [0] * _WIDE),
            )

        def part(pointer, k):
            return builder.bitcast(at(pointer, k * _WIDE), vector.as_pointer())

        screws, draws, bias, out = (of_pose(array) for array in arrays)
        before = builder.block
        first = [in_all_lanes(at(bias, c)) for c in range(3)]
        loop, done = builder.append_basic_block("terms"), builder.append_basic_block("done")
        builder.branch(loop)
        builder.position_at_end(loop)
        term = builder.phi(index)
        sums = [[builder.phi(vector) for _ in range(_PARTS)] for _ in range(3)]
        screw = [in_all_lanes(at(at(screws, builder.mul(term, index(3))), c)) for c in range(3)]
        drawn = at(builder.inttoptr(builder.load(at(draws, term)), real.as_pointer()), lane)
        added = [[], [], []]
        for k in range(_PARTS):
            numbers = builder.load(part(drawn, k), align=8)
            for c in range(3):
                added[c].append(builder.call(fused, (screw[c], numbers, sums[c][k])))
        following = builder.add(term, index(1))
        for phi, start, then in [
            (term, index(0), following),
            *((sums[c][k], first[c], added[c][k]) for c in range(3) for k in range(_PARTS)),
        ]:
            phi.add_incoming(start, before)
            phi.add_incoming(then, loop)
        builder.cbranch(builder.icmp_signed("<", following, terms), loop, done)
        builder.position_at_end(done)
        for k in range(_PARTS):
            x, y, z = (added[c][k] for c in range(3))
            square = builder.call(fused, (z, z, builder.call(fused, (y, y, builder.fmul(x, x)))))
            builder.store(square, part(at(out, lane), k), align=8)
        return context.get_dummy_value()

    return signature, written


@compiled
def squared_lengths(poses, count, terms, screws, draws, bias, out):
    """Write the squared error |bias + sum over terms of screw x draw|^2 of each robot at each pose
    to out (pose, robot), m^2.

    The sum runs in the order of the terms. Arrays may have more poses than `poses`, but must be
    contiguous.

    poses    number of poses
    count    number of robots, a multiple of sixteen
    terms    (pose,) number of terms that count at each pose, the first ones
    screws   (pose, term, 3) m per unit draw
    draws    (pose, term) address of the first robot's draw of each term; the draws of the other
             robots follow it in memory
    bias     (pose, 3) m
    """
    for first in range(0, count, _STEP):
        for k in range(poses):
            if terms[k] == 0:
                for i in range(first, min(first + _STEP, count)):
                    out[k, i] = fma(
                        bias[k, 2], bias[k, 2], fma(bias[k, 1], bias[k, 1], bias[k, 0] * bias[k, 0])
                    )
                continue
            for i in range(first, min(first + _STEP, count), AT_ONCE):
                _squares_of_sixteen(terms[k], screws, draws, bias, k, i, out)
