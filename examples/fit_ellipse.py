"""fit_ellipse: the symbolic engine alone, without mechanics: an ellipse through noisy points by Gauss-Newton.

What it shows: residuals written in Python, compiled with exact Jacobians, evaluated for all points at once.
The ellipse has centre c, half-axes a > b [m] and angle phi [rad]; the residual of a point p is its algebraic
distance |D R(-phi) (p - c)| - 1 with D = diag(1/a, 1/b), weighted by the mean half-axis.

    python examples/fit_ellipse.py            fits, checks itself, prints the iterations
"""

import sys
from typing import Annotated

import numpy as np

import stark.symbolic as sym


@sym.function
def residual(q: Annotated[sym.Vec, 5], p: sym.Vec2):
    """Weighted algebraic distance [m] of a point p from the ellipse q = (cx, cy, a, b, phi)."""
    d = p - q[:2]
    c, s = sym.cos(q[4]), sym.sin(q[4])
    u = sym.vec((c * d[0] + s * d[1]) / q[2], (c * d[1] - s * d[0]) / q[3])
    return 0.5 * (q[2] + q[3]) * (sym.norm(u) - 1.0)


def measured_points(truth: np.ndarray, count: int, noise: float) -> np.ndarray:
    """Points [m] on the ellipse, each coordinate with a normal error of standard deviation `noise` [m]."""
    random = np.random.default_rng(1)
    t = random.uniform(0.0, 2.0 * np.pi, count)
    c, s = np.cos(truth[4]), np.sin(truth[4])
    x, y = truth[2] * np.cos(t), truth[3] * np.sin(t)
    exact = np.column_stack([truth[0] + c * x - s * y, truth[1] + s * x + c * y])
    return exact + random.normal(0.0, noise, exact.shape)


def fit(points: np.ndarray) -> tuple[np.ndarray, list[float]]:
    """Gauss-Newton from the circle around the points: parameters, sums of squares [m^2] by iteration."""
    center = points.mean(axis=0)
    radius = np.linalg.norm(points - center, axis=1).mean()
    q = np.array([*center, 1.1 * radius, 0.9 * radius, 0.5])
    history = []
    for _ in range(30):
        r, J = residual.value_and_jacobian(q, points)  # (n,), (n, 5)
        history.append(float(r @ r))
        step = np.linalg.lstsq(J, -r, rcond=None)[0]
        # A step must lower the sum of squares; where the model is poor, a shorter one does.
        while np.sum(residual(q + step, points) ** 2) > history[-1] and np.abs(step).max() > 1e-12:
            step *= 0.5
        q = q + step
        if np.abs(step).max() < 1e-10:
            return q, history
    raise RuntimeError("Gauss-Newton has not converged in 30 iterations")


def main() -> int:
    truth = np.array([0.3, -0.2, 2.0, 0.8, 0.6])
    noise, count = 0.01, 2000
    q, history = fit(measured_points(truth, count, noise))
    print(residual.graph())
    for k, value in enumerate(history):
        print(f"iteration {k}: sum of squares {value:.6e} m^2")
    print("fitted (cx, cy, a, b, phi):", np.array2string(q, precision=5))
    # The error of each parameter is noise / sqrt(count) = 2e-4 times a factor of order 1; the weight of a
    # residual is between (a + b) / 2a and (a + b) / 2b, 1.8 times in square on average.
    good = np.abs(q - truth).max() < 10.0 * noise / np.sqrt(count) and history[-1] < 2.0 * count * noise**2
    print("check:", "passed" if good else "FAILED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
