"""The product that a study by Monte Carlo is made of: |bias + sum over terms of screw x draw|^2 for sixteen robots at once.

Written down for the compiler as vectors, because its own loops leave the sums of so many terms in memory: here three components of sixteen
robots stay in twelve registers of four numbers, and a processor with AVX2 does little else than multiply and add. A fused multiply-add rounds
once by definition, in hardware or (slowly) without: so the bits do not depend on the processor or on how wide its registers are.
"""

from __future__ import annotations

from typing import Final

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

AT_ONCE: Final = 16
_WIDE: Final = 4
_PARTS: Final = AT_ONCE // _WIDE

# No fast mathematics: every sum runs in its written order.
compiled = njit(nogil=True, cache=True, error_model="numpy", boundscheck=False)


@intrinsic
def fma(_typing, a, b, c):
    """Give a b + c, rounded once."""
    del a, b, c

    def written(_context, builder, _signature, numbers):
        return builder.fma(*numbers)

    return types.float64(types.float64, types.float64, types.float64), written


@intrinsic
def _squares_of_sixteen(_typing, screws, draws, lane, bias, out):
    """Put |bias + sum_t screws[t] draws_t[lane + i]|^2 into out[lane + i], i = 0 … 15; draws holds the address of each term's first number."""
    signature = types.void(screws, draws, lane, bias, out)

    def written(context, builder, signature, values):
        real, index = ir.DoubleType(), ir.IntType(64)
        vector = ir.VectorType(real, _WIDE)
        where = {k: make_array(signature.args[k])(context, builder, values[k]) for k in (0, 1, 3, 4)}
        terms = cgutils.unpack_tuple(builder, where[1].shape, 1)[0]
        fused = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector] * 3), f"llvm.fma.v{_WIDE}f64")

        def at(pointer, offset):
            return builder.gep(pointer, [offset if isinstance(offset, ir.Value) else index(offset)])

        def in_all_lanes(pointer):
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), builder.load(pointer), ir.IntType(32)(0))
            return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), _WIDE), [0] * _WIDE))

        def part(pointer, k):
            return builder.bitcast(at(pointer, k * _WIDE), vector.as_pointer())

        before = builder.block
        first = [in_all_lanes(at(where[3].data, c)) for c in range(3)]
        loop, done = builder.append_basic_block("terms"), builder.append_basic_block("done")
        builder.branch(loop)
        builder.position_at_end(loop)
        term = builder.phi(index)
        sums = [[builder.phi(vector) for _ in range(_PARTS)] for _ in range(3)]
        screw = [in_all_lanes(at(at(where[0].data, builder.mul(term, index(3))), c)) for c in range(3)]
        drawn = at(builder.inttoptr(builder.load(at(where[1].data, term)), real.as_pointer()), values[2])
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
            builder.store(square, part(at(where[4].data, values[2]), k), align=8)
        return context.get_dummy_value()

    return signature, written


@compiled
def squared_lengths(count, screws, draws, bias, out):
    """Put the squared error of each of `count` robots (a multiple of sixteen) into out (robot,): |bias + sum over terms of screw x draw|^2.

    screws (term, 3) and bias (3,) m; draws (term,) the address of what the first robot drew for each term, the others' draws follow it.
    Summed in the order of the terms.
    """
    if len(draws) == 0:
        for i in range(count):
            out[i] = fma(bias[2], bias[2], fma(bias[1], bias[1], bias[0] * bias[0]))
        return
    for i in range(0, count, AT_ONCE):
        _squares_of_sixteen(screws, draws, i, bias, out)
