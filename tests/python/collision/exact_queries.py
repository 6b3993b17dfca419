"""Degenerate queries of continuous collision detection, and their exact verdicts by Sturm's theorem
in integer arithmetic. The method and the language differ from the library's.
"""

from fractions import Fraction
from itertools import combinations
from math import gcd

import numpy as np

Polynomial = list[int]  # integer coefficients, constant term first; empty for the zero polynomial


def trimmed(p: Polynomial) -> Polynomial:
    n = len(p)
    while n and p[n - 1] == 0:
        n -= 1
    return p[:n]


def product(a: Polynomial, b: Polynomial) -> Polynomial:
    result = [0] * max(len(a) + len(b) - 1, 0)
    for i, x in enumerate(a):
        if x:
            for j, y in enumerate(b):
                result[i + j] += x * y
    return result


def minus(a: Polynomial, b: Polynomial) -> Polynomial:
    n = max(len(a), len(b))
    return [(a[i] if i < len(a) else 0) - (b[i] if i < len(b) else 0) for i in range(n)]


def dot(a: list[Polynomial], b: list[Polynomial]) -> Polynomial:
    result: Polynomial = []
    for x, y in zip(a, b, strict=True):
        result = minus(result, [-c for c in product(x, y)])
    return trimmed(result)


def cross(a: list[Polynomial], b: list[Polynomial]) -> list[Polynomial]:
    return [
        trimmed(minus(product(a[i], b[j]), product(a[j], b[i])))
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]


def derivative(p: Polynomial) -> Polynomial:
    return [k * c for k, c in enumerate(p)][1:]


def remainder(a: Polynomial, b: Polynomial) -> Polynomial:
    """Returns the remainder of `a` divided by `b`, up to a positive factor."""
    a, lead = list(a), b[-1]
    while len(a) >= len(b):
        top, shift = a[-1], len(a) - len(b)
        factor = top if lead > 0 else -top
        a = [x * abs(lead) for x in a]
        for i, y in enumerate(b):
            a[shift + i] -= factor * y
        a = trimmed(a)
    common = gcd(*a) if a else 1
    return [x // common for x in a]


def sign_at(p: Polynomial, numerator: int, bits: int) -> int:
    """Sign of p at numerator / 2^bits."""
    value, scale = 0, 0
    for c in reversed(p):
        value = value * numerator + (c << scale)
        scale += bits
    return (value > 0) - (value < 0)


def changes(chain: list[Polynomial], numerator: int, bits: int) -> int:
    signs = [s for p in chain if (s := sign_at(p, numerator, bits))]
    return sum(a != b for a, b in zip(signs, signs[1:], strict=False))


def chain_of(p: Polynomial, q: Polynomial) -> list[Polynomial]:
    chain = [p, q]
    while chain[-1]:
        chain.append([-x for x in remainder(chain[-2], chain[-1])])
    return chain[:-1]


class Time:
    """The dyadic number low / 2^bits, or the only root of `polynomial` between low / 2^bits and
    high / 2^bits.
    """

    def __init__(self, low: int, high: int, bits: int, polynomial: Polynomial | None = None):
        self.low, self.high, self.bits, self.polynomial = low, high, bits, polynomial

    def sign_of(self, q: Polynomial) -> int:
        if not q:
            return 0
        if self.polynomial is None:
            return sign_at(q, self.low, self.bits)
        if len(q) >= len(self.polynomial):
            q = remainder(q, self.polynomial)
            if not q:
                return 0
        # Tarski query: number of roots with q > 0 minus number of roots with q < 0.
        chain = chain_of(self.polynomial, trimmed(product(derivative(self.polynomial), q)))
        return changes(chain, self.low, self.bits) - changes(chain, self.high, self.bits)

    def upper_bound(self) -> Fraction:
        """Returns an upper bound on the time, exact or at most 2^-60 too large."""
        low, high, bits = self.low, self.high, self.bits
        if self.polynomial is not None:
            chain = chain_of(self.polynomial, derivative(self.polynomial))
            while bits < 60:
                low, high, bits, middle = 2 * low, 2 * high, bits + 1, low + high
                if sign_at(self.polynomial, middle, bits) == 0:
                    return Fraction(middle, 1 << bits)
                if changes(chain, low, bits) - changes(chain, middle, bits) == 1:
                    high = middle
                else:
                    low = middle
        return Fraction(high, 1 << bits)


def divided(p: Polynomial, numerator: int, bits: int) -> Polynomial:
    """Returns p without its factors (t - numerator / 2^bits), up to a positive factor."""
    while p and sign_at(p, numerator, bits) == 0:
        # Long division by (2^bits t - numerator). With p scaled first, all numbers are integers.
        quotient, rest = [], 0
        for c in reversed([c << (bits * (len(p) - 1)) for c in p]):
            rest = (c + numerator * rest) >> bits if quotient else c >> bits
            quotient.append(rest)
        quotient = trimmed(quotient[-2::-1])
        common = gcd(*quotient)
        p = [c // common for c in quotient]
    return p


def roots(p: Polynomial) -> list[Time]:
    """Returns the times in [0, 1] where p is 0; p must not be the zero polynomial."""
    found = [Time(end, end, 0) for end in (0, 1) if sign_at(p, end, 0) == 0]
    inner = divided(divided(p, 0, 0), 1, 0)
    chain = chain_of(inner, derivative(inner)) if len(inner) > 1 else [inner]
    stack = [(0, 1, 0)]
    while stack:
        low, high, bits = stack.pop()
        count = changes(chain, low, bits) - changes(chain, high, bits)
        if count == 1:
            found.append(Time(low, high, bits, inner))
        elif count > 1:
            low, high, bits, middle = 2 * low, 2 * high, bits + 1, low + high
            if sign_at(inner, middle, bits) == 0:
                found.append(Time(middle, middle, bits))
                inner = divided(inner, middle, bits)
                chain = chain_of(inner, derivative(inner)) if len(inner) > 1 else [inner]
            stack += [(low, middle, bits), (middle, high, bits)]
    return found


class Hull:
    """Convex hull of moving corners."""

    def __init__(self, corners: list[list[Polynomial]]):
        self.corners, self.n = corners, len(corners)
        self.cross = {
            (i, j): cross(corners[i], corners[j]) for i, j in combinations(range(self.n), 2)
        }
        self.dot = {(i, j): dot(corners[i], corners[j]) for i, j in self.cross}

    def holds_origin(self, time: Time) -> bool:
        """Returns whether the hull contains the origin at `time`.

        At this time, the origin and the corners must be coplanar.
        """
        if any(all(time.sign_of(x) == 0 for x in corner) for corner in self.corners):
            return True
        known: dict[tuple[int, int, int], int] = {}

        def turn(i: int, j: int, k: int) -> int:
            """Sign of coordinate k of the cross product of corners i and j."""
            if i > j:
                return -turn(j, i, k)
            if (i, j, k) not in known:
                known[i, j, k] = time.sign_of(self.cross[i, j][k])
            return known[i, j, k]

        for i, j in self.dot:
            if time.sign_of(self.dot[i, j]) < 0 and all(turn(i, j, k) == 0 for k in range(3)):
                return True
        for i, j, m in combinations(range(self.n), 3):
            # The three cross products are parallel, because the origin and the corners are
            # coplanar. The signs of any nonzero coordinate thus show whether the products point in
            # the same direction.
            for k in range(3):
                signs = {turn(i, j, k), turn(j, m, k), turn(m, i, k)}
                if signs in ({1}, {-1}):
                    return True
                if signs != {0}:
                    break
        return False


def whole_numbers(query: np.ndarray) -> list[list[int]]:
    """Returns the points as integers, scaled by a common factor."""
    ratios = [[float(x).as_integer_ratio() for x in point] for point in query]
    bits = max(d.bit_length() - 1 for point in ratios for _, d in point)
    numbers = [[n << (bits - d.bit_length() + 1) for n, d in point] for point in ratios]
    common = gcd(*(x for point in numbers for x in point)) or 1
    return [[x // common for x in point] for point in numbers]


def exact_verdict(kind: str, query: np.ndarray) -> Fraction | None:
    """Returns an upper bound on the first contact time, at most 2^-60 too large. Returns None if
    there is no contact.
    """
    points = whole_numbers(query)
    pairs = [(0, 1), (0, 2), (0, 3)] if kind == "vertex-face" else [(0, 2), (1, 2), (0, 3), (1, 3)]
    corners = []
    for i, j in pairs:
        start = [a - b for a, b in zip(points[i], points[j], strict=True)]
        end = [a - b for a, b in zip(points[4 + i], points[4 + j], strict=True)]
        corners.append([trimmed([s, e - s]) for s, e in zip(start, end, strict=True)])
    # There is no contact if one coordinate has the same sign at all corners and all times, or if
    # the triple product of the first three corners keeps its sign.
    for k in range(3):
        ends = [
            s for corner in corners for s in (sign_at(corner[k], 0, 0), sign_at(corner[k], 1, 0))
        ]
        if min(ends) > 0 or max(ends) < 0:
            return None
    volume = dot(corners[0], cross(corners[1], corners[2]))
    if volume:
        a, b, c, d = volume + [0] * (4 - len(volume))
        bernstein = a, 3 * a + b, 3 * a + 2 * b + c, a + b + c + d
        if min(bernstein) > 0 or max(bernstein) < 0:
            return None
    hull = Hull(corners)
    if volume:
        times = roots(volume)
    else:  # always coplanar: contact begins at 0 or at a root of a coordinate or cross product
        events = [x for corner in corners for x in corner] + [
            c for normal in hull.cross.values() for c in normal
        ]
        times = [Time(0, 0, 0), Time(1, 1, 0)] + [time for p in events if p for time in roots(p)]
    return min((time.upper_bound() for time in times if hull.holds_origin(time)), default=None)


FAMILIES = (
    "generic",
    "lattice",
    "start",
    "end",
    "at rest",
    "parallel",
    "collinear",
    "sliver",
    "plane",
    "together",
    "through",
)


def degenerate_queries(random: np.random.Generator, kind: str, family: str, n: int) -> np.ndarray:
    """Returns n queries (n x 8 x 3) of a family. About a third of them are off by one unit in the
    last place of one coordinate. About a third are scaled, mostly by extreme factors.
    """
    size = int(random.integers(2, 6))
    q = random.integers(-size, size + 1, size=(n, 8, 3)).astype(float)
    start, end = q[:, :4], q[:, 4:]
    # Weights of the point of contact: multiples of 1/4, with which no rounding occurs.
    weights = random.multinomial(4, [1 / 3] * 3, size=n) / 4.0
    if family == "generic":
        q[:] = random.normal(size=q.shape)
        if random.random() < 0.5:
            end[:] = start + 0.2 * end
    elif family in ("start", "end", "through"):
        here = start if family == "start" else end
        if kind == "vertex-face":
            here[:, 0] = np.einsum("ni,nik->nk", weights, here[:, 1:])
        else:
            s, t = (random.integers(0, 5, size=(n, 1)) / 4.0 for _ in range(2))
            other = (1 - t) * here[:, 2] + t * here[:, 3]
            arm = here[:, 1] - here[:, 0]
            here[:, 0] = other - s * arm
            here[:, 1] = other + (1 - s) * arm
        if family == "through":  # doubles the displacement, so that contact is half-way
            end[:] = 2 * end - start
    elif family == "at rest":
        end[:] = start
    elif family == "parallel":
        if kind == "vertex-face":
            q[:, :, 2] = 0.0
            q[:, [0, 4], 2] = random.integers(-2, 3, size=(n, 2))
        else:
            start[:, 3] = start[:, 2] + random.integers(-2, 3, size=(n, 1)) * (
                start[:, 1] - start[:, 0]
            )
            end[:, 3] = end[:, 2] + random.integers(-2, 3, size=(n, 1)) * (end[:, 1] - end[:, 0])
    elif family == "collinear":
        steps = random.integers(-4, 5, size=(n, 8, 1))
        q[:] = q[:, :1] + steps * q[:, 1:2]
        q[:, 4:] += random.integers(-1, 2, size=(n, 1, 3)) * (random.random() < 0.3)
    elif family == "sliver":
        q[:, 3] = q[:, 2] + 1e-12 * random.normal(size=(n, 3))
        q[:, 7] = q[:, 6] + 1e-12 * random.normal(size=(n, 3))
    elif family == "plane":
        q[:, :, 2] = q[:, :, 0] if random.random() < 0.5 else 0.0
    elif family == "together":
        end[:] = start + random.integers(-3, 4, size=(n, 1, 3))
        end[:, 0] += random.integers(-1, 2, size=(n, 3))
    for i in np.flatnonzero(random.random(n) < 1 / 3):
        point, axis = random.integers(8), random.integers(3)
        q[i, point, axis] = np.nextafter(q[i, point, axis], random.choice([-np.inf, np.inf]))
    scaled = random.random(n) < 1 / 3
    q[scaled] *= random.choice(
        [1e-40, 2.0**-133, 1e30, 2.0**100, 0.1], size=(int(scaled.sum()), 1, 1)
    )
    return q
