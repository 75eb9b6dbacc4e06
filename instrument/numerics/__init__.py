"""Mathematics on arrays: splines and smoothing, total variation and its solvers, operators, compiled loops, metrics."""

from instrument.numerics.blas import one_blas_thread
from instrument.numerics.circle import Circle, fit_circle
from instrument.numerics.compiled import compiled, inlined
from instrument.numerics.dense_products import DenseProducts
from instrument.numerics.fading import add, age, solve
from instrument.numerics.intervals import coverage_factor
from instrument.numerics.metrics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local
from instrument.numerics.operators import Layered, Operator, Stacked, Unseen, Weighted, largest_eigenvalue
from instrument.numerics.row_products import RowProducts
from instrument.numerics.side_by_side import side_by_side
from instrument.numerics.smoothing import Smooth, smooth
from instrument.numerics.spline import Spline
from instrument.numerics.tv import EIGENVALUE_MARGIN, TvState, total_variation
from instrument.numerics.tv_steps import close_border
from instrument.numerics.tval3 import AlState, tv_augmented_lagrangian

__all__ = [
    "EIGENVALUE_MARGIN",
    "AlState",
    "Circle",
    "DenseProducts",
    "Layered",
    "Operator",
    "RowProducts",
    "Smooth",
    "Spline",
    "Stacked",
    "TvState",
    "Unseen",
    "Weighted",
    "add",
    "age",
    "close_border",
    "compiled",
    "coverage_factor",
    "displacement_mse",
    "fit_circle",
    "inlined",
    "largest_eigenvalue",
    "offset_free_mse",
    "one_blas_thread",
    "psnr",
    "side_by_side",
    "smooth",
    "solve",
    "ssim_global",
    "ssim_local",
    "total_variation",
    "tv_augmented_lagrangian",
]
