"""Calibration of material laws from measured curves: ``stark.fit`` and what it returns."""

from stark.calibration.fitting import fit
from stark.calibration.result import CurveFit, Fit

__all__ = ["CurveFit", "Fit", "fit"]
