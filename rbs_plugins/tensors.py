"""Second-order tensors for laws: plain functions of 3 x 3 numbers ((xx, xy, xz), (yx, yy, yz), (zx, zy, zz)).

    from rbs_plugins.tensors import product, symmetric, trace

    def mine(F, lame, G):
        ...

Nothing is allocated and nothing branches: compiled into the loop over nodes they vectorise, and in plain Python they
take the same tuples. Every function returns such tuples, or a number.
"""

from __future__ import annotations

from math import sqrt

__all__ = [
    "added", "cauchy_stress", "determinant", "deviator", "green_strain", "identity", "inner", "inverse", "norm",
    "principal", "product", "scaled", "spectral", "symmetric", "trace", "transpose",
]  # fmt: skip


def identity():
    """I."""
    return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def added(A, B, factor=1.0):
    """A + factor B."""
    return (
        (A[0][0] + factor * B[0][0], A[0][1] + factor * B[0][1], A[0][2] + factor * B[0][2]),
        (A[1][0] + factor * B[1][0], A[1][1] + factor * B[1][1], A[1][2] + factor * B[1][2]),
        (A[2][0] + factor * B[2][0], A[2][1] + factor * B[2][1], A[2][2] + factor * B[2][2]),
    )


def scaled(A, factor):
    """Factor A."""
    return (
        (factor * A[0][0], factor * A[0][1], factor * A[0][2]),
        (factor * A[1][0], factor * A[1][1], factor * A[1][2]),
        (factor * A[2][0], factor * A[2][1], factor * A[2][2]),
    )


def transpose(A):
    """A^T."""
    return ((A[0][0], A[1][0], A[2][0]), (A[0][1], A[1][1], A[2][1]), (A[0][2], A[1][2], A[2][2]))


def _row(a, B):
    """The row a B, a three numbers."""
    return (
        a[0] * B[0][0] + a[1] * B[1][0] + a[2] * B[2][0],
        a[0] * B[0][1] + a[1] * B[1][1] + a[2] * B[2][1],
        a[0] * B[0][2] + a[1] * B[1][2] + a[2] * B[2][2],
    )


def product(A, B):
    """A B."""
    return (_row(A[0], B), _row(A[1], B), _row(A[2], B))


def trace(A):
    """Tr A."""
    return A[0][0] + A[1][1] + A[2][2]


def inner(A, B):
    """A : B = Σ A_ab B_ab."""
    return (
        A[0][0] * B[0][0] + A[0][1] * B[0][1] + A[0][2] * B[0][2]
        + A[1][0] * B[1][0] + A[1][1] * B[1][1] + A[1][2] * B[1][2]
        + A[2][0] * B[2][0] + A[2][1] * B[2][1] + A[2][2] * B[2][2]
    )  # fmt: skip


def norm(A):
    """sqrt(A : A)."""
    return sqrt(inner(A, A))


def symmetric(A):
    """(A + A^T) / 2."""
    xy, xz, yz = 0.5 * (A[0][1] + A[1][0]), 0.5 * (A[0][2] + A[2][0]), 0.5 * (A[1][2] + A[2][1])
    return ((A[0][0], xy, xz), (xy, A[1][1], yz), (xz, yz, A[2][2]))


def deviator(A):
    """A − tr(A)/3 I."""
    mean = trace(A) / 3.0
    return (
        (A[0][0] - mean, A[0][1], A[0][2]),
        (A[1][0], A[1][1] - mean, A[1][2]),
        (A[2][0], A[2][1], A[2][2] - mean),
    )


def _cofactors(A):
    """Of A, so that A^-1 is their transpose over det A."""
    return (
        (A[1][1] * A[2][2] - A[1][2] * A[2][1], A[1][2] * A[2][0] - A[1][0] * A[2][2],
         A[1][0] * A[2][1] - A[1][1] * A[2][0]),
        (A[0][2] * A[2][1] - A[0][1] * A[2][2], A[0][0] * A[2][2] - A[0][2] * A[2][0],
         A[0][1] * A[2][0] - A[0][0] * A[2][1]),
        (A[0][1] * A[1][2] - A[0][2] * A[1][1], A[0][2] * A[1][0] - A[0][0] * A[1][2],
         A[0][0] * A[1][1] - A[0][1] * A[1][0]),
    )  # fmt: skip


def determinant(A):
    """Det A."""
    return (
        A[0][0] * (A[1][1] * A[2][2] - A[1][2] * A[2][1])
        + A[0][1] * (A[1][2] * A[2][0] - A[1][0] * A[2][2])
        + A[0][2] * (A[1][0] * A[2][1] - A[1][1] * A[2][0])
    )


def inverse(A):
    """A^-1; infinite or NaN if A is singular."""
    return scaled(transpose(_cofactors(A)), 1.0 / determinant(A))


def green_strain(F):
    """E = (F^T F − I) / 2, from the displacement gradient H = F − I, so that small strains keep their digits."""
    H = added(F, identity(), -1.0)
    return symmetric(added(H, product(transpose(H), H), 0.5))


def cauchy_stress(P, F):
    """σ = P F^T / det F, of a first Piola-Kirchhoff stress."""
    return scaled(product(P, transpose(F)), 1.0 / determinant(F))


# -- principal values ----------------------------------------------------------------------------------------------


def _turn(pp, qq, pq):
    """Cosine and sine of the rotation that makes pq vanish (Jacobi)."""
    apart = qq - pp
    below = abs(apart) + sqrt(apart * apart + 4.0 * pq * pq)
    upper = 2.0 * pq if apart >= 0.0 else -2.0 * pq
    t = upper / (below if below > 0.0 else 1.0)
    c = 1.0 / sqrt(1.0 + t * t)
    return c, t * c, t


def _turned(p, q, c, s):
    """Two directions, turned in their plane."""
    return (
        (c * p[0] - s * q[0], c * p[1] - s * q[1], c * p[2] - s * q[2]),
        (s * p[0] + c * q[0], s * p[1] + c * q[1], s * p[2] + c * q[2]),
    )


def _swept(values, sides, V):
    """One sweep of rotations about the three axes; values (x, y, z), sides (xy, xz, yz), V rows of directions."""
    x, y, z = values
    xy, xz, yz = sides
    c, s, t = _turn(x, y, xy)
    x, y, xz, yz = x - t * xy, y + t * xy, c * xz - s * yz, s * xz + c * yz
    first, second = _turned(V[0], V[1], c, s)
    third = V[2]
    c, s, t = _turn(x, z, xz)
    x, z, xy, yz = x - t * xz, z + t * xz, -s * yz, c * yz
    first, third = _turned(first, third, c, s)
    c, s, t = _turn(y, z, yz)
    y, z, xy, xz = y - t * yz, z + t * yz, c * xy, s * xy
    second, third = _turned(second, third, c, s)
    return (x, y, z), (xy, xz, 0.0), (first, second, third)


def principal(A):
    """Eigenvalues of a symmetric tensor, in no order, and their unit vectors as rows: A = Σ v_k n_k⊗n_k.

    Five sweeps of Jacobi's rotations, which converge quadratically: exact to round-off for any symmetric 3 x 3 tensor,
    equal eigenvalues included.
    """
    values, sides, V = _swept((A[0][0], A[1][1], A[2][2]), (A[0][1], A[0][2], A[1][2]), identity())
    values, sides, V = _swept(values, sides, V)
    values, sides, V = _swept(values, sides, V)
    values, sides, V = _swept(values, sides, V)
    values, sides, V = _swept(values, sides, V)
    return values, V


def spectral(values, V):
    """Σ v_k n_k⊗n_k from principal values and unit vectors."""
    a, b, c = values
    xx = a * V[0][0] * V[0][0] + b * V[1][0] * V[1][0] + c * V[2][0] * V[2][0]
    yy = a * V[0][1] * V[0][1] + b * V[1][1] * V[1][1] + c * V[2][1] * V[2][1]
    zz = a * V[0][2] * V[0][2] + b * V[1][2] * V[1][2] + c * V[2][2] * V[2][2]
    xy = a * V[0][0] * V[0][1] + b * V[1][0] * V[1][1] + c * V[2][0] * V[2][1]
    xz = a * V[0][0] * V[0][2] + b * V[1][0] * V[1][2] + c * V[2][0] * V[2][2]
    yz = a * V[0][1] * V[0][2] + b * V[1][1] * V[1][2] + c * V[2][1] * V[2][2]
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
