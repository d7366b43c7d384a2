"""The product that a study by Monte Carlo is made of: |bias + sum over terms of screw x draw|^2 for sixteen robots at once.

Written down for the compiler as vectors, because its own loops leave the sums of so many terms in memory: here three components of sixteen
robots stay in twelve registers of four numbers or six of eight, and the processor does little else than multiply and add. A fused multiply-add rounds
once by definition, in hardware or (slowly) without: so the bits do not depend on the processor or on how wide its registers are.
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
# With AVX-512 a register holds eight numbers; more than it holds, split by the compiler, would leave sums in memory.
_WIDE: Final = 8 if binding.get_host_cpu_features().get("avx512f") else 4
_PARTS: Final = AT_ONCE // _WIDE
# So many robots' draws at a time as leave room in the first cache for everything else.
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
    """Put |bias + sum_t screws[t] draws_t[lane + i]|^2 of one pose into out[pose, lane + i], i = 0 … 15, over the first terms, one at least."""
    if any(array.layout != "C" for array in (screws, draws, bias, out)):
        return None
    signature = types.void(terms, screws, draws, bias, pose, lane, out)

    def written(context, builder, signature, values):
        real, index = ir.DoubleType(), ir.IntType(64)
        vector = ir.VectorType(real, _WIDE)
        arrays = [make_array(signature.args[k])(context, builder, values[k]) for k in (1, 2, 3, 6)]
        terms, pose, lane = values[0], values[4], values[5]
        fused = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fma.v{_WIDE}f64")

        def at(pointer, offset):
            return builder.gep(pointer, [offset if isinstance(offset, ir.Value) else index(offset)])

        def of_pose(array):
            """Skip the poses before this one: as many numbers each as all further axes hold."""
            begin = pose
            for length in cgutils.unpack_tuple(builder, array.shape)[1:]:
                begin = builder.mul(begin, length)
            return at(array.data, begin)

        def in_all_lanes(pointer):
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), builder.load(pointer), ir.IntType(32)(0))
            return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), _WIDE), [0] * _WIDE))

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
        for phi, start, then in [(term, index(0), following), *((sums[c][k], first[c], added[c][k]) for c in range(3) for k in range(_PARTS))]:
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
    """Put the squared error of each of `count` robots (a multiple of sixteen) at each of these poses into out (pose, robot), in m^2.

    |bias + sum over terms of screw x draw|^2, summed in the order of the terms: screws (pose, term, 3) and bias (pose, 3) in m; draws (pose, term)
    the address of what the first robot drew for each term, the others' draws follow it. Of each pose the first `terms` (pose,) count. Arrays may hold
    more poses than these, but no gaps.
    """
    for first in range(0, count, _STEP):
        for k in range(poses):
            if terms[k] == 0:
                for i in range(first, min(first + _STEP, count)):
                    out[k, i] = fma(bias[k, 2], bias[k, 2], fma(bias[k, 1], bias[k, 1], bias[k, 0] * bias[k, 0]))
                continue
            for i in range(first, min(first + _STEP, count), AT_ONCE):
                _squares_of_sixteen(terms[k], screws, draws, bias, k, i, out)
