from .blas import one_blas_thread as one_blas_thread
from .circle import Circle as Circle
from .circle import fit_circle as fit_circle
from .compiled import compiled as compiled
from .compiled import inlined as inlined
from .dense_products import DenseProducts as DenseProducts
from .fading import add as add
from .fading import age as age
from .fading import solve as solve
from .in_time import InTime as InTime
from .intervals import coverage_factor as coverage_factor
from .metrics import displacement_mse as displacement_mse
from .metrics import offset_free_mse as offset_free_mse
from .metrics import psnr as psnr
from .metrics import ssim_global as ssim_global
from .metrics import ssim_local as ssim_local
from .operators import Layered as Layered
from .operators import Operator as Operator
from .operators import Stacked as Stacked
from .operators import Unseen as Unseen
from .operators import Weighted as Weighted
from .operators import largest_eigenvalue as largest_eigenvalue
from .robust import step_noise as step_noise
from .row_products import RowProducts as RowProducts
from .side_by_side import side_by_side as side_by_side
from .smoothing import Smooth as Smooth
from .smoothing import smooth as smooth
from .spline import Spline as Spline
from .tv import EIGENVALUE_MARGIN as EIGENVALUE_MARGIN
from .tv import TvState as TvState
from .tv import total_variation as total_variation
from .tv_steps import close_border as close_border
from .tval3 import AlState as AlState
from .tval3 import tv_augmented_lagrangian as tv_augmented_lagrangian

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
    "step_noise",
    "total_variation",
    "tv_augmented_lagrangian",
]
