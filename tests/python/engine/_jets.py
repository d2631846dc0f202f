"""Oracle of the engine's property tests: second-order forward jets with running error bounds.

A jet holds a value, its gradient and its Hessian for a batch of elements, computed by the chain rule in
float64 and nothing else: no graph, no simplification, no code shared with the engine. Beside each it has

  magnitude  sum of the absolute values over all paths of the chain rule, which bounds what any order of
             summation (forward, reverse, edge pushing, staged) can cancel,
  error      first-order bound of the rounding error that any such order can make: errors of operands times
             partial derivatives, one unit of rounding of the magnitude per operation.

So tolerances follow the condition of each formula instead of being one number for all. An error that is not
finite means "nothing can be said here": a comparison of values closer than their errors, or a number so large
or small that products of derivatives leave the range of float64. A branch that is not taken contributes
nothing."""

from __future__ import annotations

import math

import numpy as np

U = 2.0**-53  # unit of rounding
LARGEST, SMALLEST = 1e60, 1e-60  # fourth powers stay within float64


class Jet:
    """Arrays with the elements last: value (B,), gradient (n, B), Hessian (n, n, B); each with its magnitude
    (that of the value is its absolute value) and its error."""

    __slots__ = ("H", "H_error", "H_size", "g", "g_error", "g_size", "v", "v_error")

    def __init__(self, v, v_error, g, g_size, g_error, H, H_size, H_error):
        self.v, self.v_error = v, v_error
        self.g, self.g_size, self.g_error = g, g_size, g_error
        self.H, self.H_size, self.H_error = H, H_size, H_error

    def arrays(self):
        return [getattr(self, name) for name in ARRAYS]

    def __add__(self, b):
        return add(self, jet(b, self))

    def __radd__(self, b):
        return add(jet(b, self), self)

    def __sub__(self, b):
        return add(self, -jet(b, self))

    def __rsub__(self, b):
        return add(jet(b, self), -self)

    def __mul__(self, b):
        return multiply(self, jet(b, self))

    def __rmul__(self, b):
        return multiply(jet(b, self), self)

    def __truediv__(self, b):
        return divide(self, jet(b, self))

    def __rtruediv__(self, b):
        return divide(jet(b, self), self)

    def __pow__(self, b):
        return pow(self, b)

    def __neg__(self):
        return chain((self,), -self.v, [-ones(self)], exact=True)

    def __lt__(self, b):
        return Condition.compare(np.less, self, jet(b, self))

    def __le__(self, b):
        return Condition.compare(np.less_equal, self, jet(b, self))

    def __gt__(self, b):
        return Condition.compare(np.greater, self, jet(b, self))

    def __ge__(self, b):
        return Condition.compare(np.greater_equal, self, jet(b, self))


ARRAYS = ("v", "v_error", "g", "g_size", "g_error", "H", "H_size", "H_error")


class Condition:
    """Truth per element, and where rounding may decide it the other way."""

    def __init__(self, truth, doubtful):
        self.truth, self.doubtful = truth, doubtful

    @staticmethod
    def compare(function, a, b):
        # A difference of exactly known numbers is never in doubt. NaN is: the engine may simplify it away.
        gap = np.abs(a.v - b.v)
        error = SAFETY * (a.v_error + b.v_error)
        return Condition(function(a.v, b.v), ~((gap > error) | (error == 0.0)) | np.isnan(gap))

    def __and__(self, b):
        # In doubt only where the other side does not decide.
        sure = (~self.truth & ~self.doubtful) | (~b.truth & ~b.doubtful)
        return Condition(self.truth & b.truth, (self.doubtful | b.doubtful) & ~sure)

    def __or__(self, b):
        return ~(~self & ~b)

    def __invert__(self):
        return Condition(~self.truth, self.doubtful)


SAFETY = 64.0  # sums of some tens of terms, functions of a few ulp


def variables(values, count):
    """Jets of inputs from values (inputs, B); the first `count` are differentiated."""
    result = []
    for i, v in enumerate(values):
        x = constant(v, count)
        if i < count:
            x.g[i] = x.g_size[i] = 1.0
        result.append(x)
    return result


def constant(v, n):
    v = np.asarray(v, dtype=np.float64)
    zeros = [np.zeros((n, v.size)) for _ in range(3)] + [np.zeros((n, n, v.size)) for _ in range(3)]
    return bounded(Jet(v, np.zeros_like(v), *zeros))


def jet(x, like):
    return x if isinstance(x, Jet) else constant(np.full(like.v.shape, float(x)), len(like.g))


def ones(x):
    return np.ones_like(x.v)


def bounded(x, lost=False):
    """Marks elements about which nothing can be said."""
    size = np.abs(x.v)
    lost = lost | (size > LARGEST) | ((size > 0.0) & (size < SMALLEST))
    x.v_error = np.where(lost, np.inf, x.v_error)
    return x


def outer(a, b):
    return a[:, None] * b[None, :]


def chain(operands, v, first, second=None, third=None, *, scales=(0.0, 0.0, 0.0), lost=False, exact=False):
    """f(operands) from its partial derivatives: first[k], second[k][l], third[k][l][m], absent ones zero.
    scales: errors of value, first and second partials beyond one unit of each, in units of rounding."""
    u = 0.0 if exact else U
    count = len(operands)
    v_error = u * (np.abs(v) + scales[0])
    n = len(operands[0].g)
    g, g_size, g_error = (np.zeros((n, v.size)) for _ in range(3))
    H, H_size, H_error = (np.zeros((n, n, v.size)) for _ in range(3))
    for k, x in enumerate(operands):
        d = np.abs(first[k])
        v_error = v_error + d * x.v_error
        d_error = u * (d + scales[1])
        for m in range(count if second else 0):
            d_error = d_error + absolute(second[k][m]) * operands[m].v_error
        g += first[k] * x.g
        g_size += d * x.g_size
        g_error += d_error * x.g_size + d * x.g_error + u * d * x.g_size
        H += first[k] * x.H
        H_size += d * x.H_size
        H_error += d_error * x.H_size + d * x.H_error + u * d * x.H_size
    for k in range(count if second else 0):
        for m in range(count):
            if second[k][m] is None:
                continue
            x, y, dd = operands[k], operands[m], np.abs(second[k][m])
            dd_error = u * (dd + scales[2])
            for j in range(count if third else 0):
                dd_error = dd_error + absolute(third[k][m][j]) * operands[j].v_error
            both = outer(x.g_size, y.g_size)
            H += second[k][m] * outer(x.g, y.g)
            H_size += dd * both
            H_error += dd_error * both + dd * (outer(x.g_error, y.g_size) + outer(x.g_size, y.g_error))
    return bounded(Jet(v, v_error, g, g_size, g_error, H, H_size, H_error), lost)


def absolute(x):
    return 0.0 if x is None else np.abs(x)


def unary(x, v, d1, d2, d3, *, scales=(0.0, 0.0, 0.0), lost=False):
    return chain((x,), v, [d1], [[d2]], [[[d3]]], scales=scales, lost=lost)


def add(a, b):
    return chain((a, b), a.v + b.v, [ones(a), ones(a)])


def multiply(a, b):
    return chain((a, b), a.v * b.v, [b.v, a.v], [[None, ones(a)], [ones(a), None]])


def fma(a, b, c):
    return a * b + c


def divide(a, b):
    r = 1.0 / b.v
    q = a.v / b.v
    return chain(
        (a, b),
        q,
        [r, -q * r],
        [[None, -r * r], [-r * r, 2.0 * q * r * r]],
        [[[None, None], [None, 2.0 * r**3]], [[None, 2.0 * r**3], [2.0 * r**3, -6.0 * q * r**3]]],
    )


def where(condition, a, b):
    like = a if isinstance(a, Jet) else b
    a, b = jet(a, like), jet(b, like)
    chosen = Jet(*(np.where(condition.truth, x, y) for x, y in zip(a.arrays(), b.arrays(), strict=True)))
    return bounded(chosen, condition.doubtful)


def minimum(a, b):
    like = a if isinstance(a, Jet) else b
    a, b = jet(a, like), jet(b, like)
    return where(a < b, a, b)


def maximum(a, b):
    like = a if isinstance(a, Jet) else b
    a, b = jet(a, like), jet(b, like)
    return where(a > b, a, b)


def abs(x):
    # |x| = |-x| is used by the engine, so the slope at zero may have either sign.
    s = np.where(x.v < 0.0, -1.0, 1.0)
    return bounded(chain((x,), np.abs(x.v), [s], exact=True), np.abs(x.v) <= SAFETY * x.v_error)


def sqrt(x):
    s = np.sqrt(x.v)
    return unary(x, s, 0.5 / s, -0.25 / (s * x.v), 0.375 / (s * x.v * x.v))


def square(x):
    return x * x


def exp(x):
    e = np.exp(x.v)
    return unary(x, e, e, e, e, lost=x.v < -130.0)


def log(x):
    r = 1.0 / x.v
    return unary(x, np.log(x.v), r, -r * r, 2.0 * r**3)


def sin(x):
    s, c = np.sin(x.v), np.cos(x.v)
    return unary(x, s, c, -s, -c, lost=np.abs(x.v) > 1e9)


def cos(x):
    s, c = np.sin(x.v), np.cos(x.v)
    return unary(x, c, -s, -c, s, lost=np.abs(x.v) > 1e9)


def tan(x):
    t = np.tan(x.v)
    d = 1.0 + t * t
    return unary(x, t, d, 2.0 * t * d, 2.0 * d * (1.0 + 3.0 * t * t), lost=np.abs(x.v) > 1e9)


def arc(x, v, sign):
    w = (1.0 - x.v) * (1.0 + x.v)
    d = sign / np.sqrt(w)
    third = (1.0 + 2.0 * x.v * x.v) * d / (w * w)
    # Where the first derivative is differentiated as an expression, (1 - x)(1 + x) cancels.
    return unary(x, v, d, x.v * d / w, third, scales=(0.0, 0.0, 2.0 * np.abs(d) / w))


def asin(x):
    return arc(x, np.arcsin(x.v), 1.0)


def acos(x):
    return arc(x, np.arccos(x.v), -1.0)


def atan(x):
    d = 1.0 / (1.0 + x.v * x.v)
    return unary(x, np.arctan(x.v), d, -2.0 * x.v * d * d, (6.0 * x.v * x.v - 2.0) * d**3)


def tanh(x):
    # The engine forms 1 - t^2 from t, with errors relative to 1.
    t = np.tanh(x.v)
    d = 1.0 / np.cosh(np.minimum(np.abs(x.v), 300.0)) ** 2
    return unary(x, t, d, -2.0 * t * d, (6.0 * t * t - 2.0) * d, scales=(0.0, 2.0, 4.0))


def sinh(x):
    s, c = np.sinh(x.v), np.cosh(x.v)
    t = tanh(0.5 * x)
    composed = where(abs(x) < 1.0, 2.0 * t / (1.0 - t * t), 0.5 * (exp(x) - exp(-x)))
    return with_bounds(unary(x, s, c, s, c), composed)


def cosh(x):
    s, c = np.sinh(x.v), np.cosh(x.v)
    return with_bounds(unary(x, c, s, c, s), 0.5 * (exp(x) + exp(-x)))


def with_bounds(x, composed):
    """x with the magnitudes and errors of the same function composed of others, as it is for the engine."""
    for name in ("v_error", "g_size", "g_error", "H_size", "H_error"):
        setattr(x, name, getattr(composed, name))
    return x


def atan2(y, x):
    like = y if isinstance(y, Jet) else x
    y, x = jet(y, like), jet(x, like)
    w = 1.0 / (x.v * x.v + y.v * y.v)
    a, b = x.v * w, y.v * w  # of size w^(1/2)
    mixed, twice = b * b - a * a, 2.0 * a * b
    third = [[2.0 * w**1.5] * 2] * 2  # bound
    # y = 0 beside x < 0 is the cut: the sign of zero decides.
    cut = (np.abs(y.v) <= SAFETY * y.v_error) & ((x.v <= SAFETY * x.v_error) | (x.v == 0.0))
    return chain(
        (y, x),
        np.arctan2(y.v, x.v),
        [a, -b],
        [[-twice, mixed], [mixed, twice]],
        [third, third],
        scales=(0.0, 0.0, 2.0 * w),
        lost=cut | (np.abs(y.v) == 0.0) & (x.v < 0.0),
    )


def pow(a, b):
    if isinstance(b, int) or (isinstance(b, float) and b == math.floor(b) and math.fabs(b) <= 64.0):
        return integer_power(a, int(b))
    if isinstance(a, Jet) and isinstance(b, float):
        v = np.where(a.v < 0.0, np.nan, np.power(a.v, b))
        first, second, third = (real_partial(a.v, b, order) for order in (1, 2, 3))
        return unary(a, v, first, second, third, lost=(v == 0.0) & (a.v != 0.0))
    like = a if isinstance(a, Jet) else b
    return general_power(jet(a, like), jet(b, like))


def falling(b, order):
    return math.prod(b - k for k in range(order))


def real_partial(x, b, order):
    c = falling(b, order)
    return np.zeros_like(x) if c == 0.0 else c * np.where(x < 0.0, np.nan, np.power(x, b - order))


def integer_power(a, n):
    def partial(order):
        c = falling(n, order)
        return np.zeros_like(a.v) if c == 0 else c * np.power(a.v, float(n - order))

    # |n| products instead of one operation.
    size = max(1.0, math.fabs(n))
    v = np.power(a.v, float(n)) if n else ones(a)
    d1, d2, d3 = partial(1), partial(2), partial(3)
    x = unary(a, v, d1, d2, d3, lost=(v == 0.0) & (a.v != 0.0))
    x.v_error, x.g_error, x.H_error = size * x.v_error, size * x.g_error, size * x.H_error
    return x


def general_power(a, b):
    x, y = a.v, b.v
    x = np.where(x < 0.0, np.nan, x)
    p, L, r = np.power(x, y), np.log(x), 1.0 / x
    q = y * L
    y1, y2 = y - 1.0, y - 2.0
    aa, ab, bb = y * y1 * p * r * r, p * r * (1.0 + q), p * L * L
    aaa = y * y1 * y2 * p * r**3
    aab = p * r * r * (np.abs(2.0 * y - 1.0) + np.abs(y * y1 * L))
    abb = p * r * (np.abs(2.0 * L) + np.abs(y * L * L))
    bbb = p * L**3
    return chain(
        (a, b),
        p,
        [y * p * r, p * L],
        [[aa, ab], [ab, bb]],
        [[[aaa, aab], [aab, abb]], [[aab, abb], [abb, bbb]]],
        # y - 1, y - 2 and 1 + y log x may cancel.
        scales=(0.0, p * r, p * r * r * (1.0 + y * y) + p * r * (1.0 + np.abs(q))),
        lost=(p == 0.0) & (x != 0.0),
    )
