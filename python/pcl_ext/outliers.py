"""Removal of noise from the voxels of a stream."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from . import _native
from .status import Status

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .codec import Decoder

Unit = Literal["automatic", "faces", "points", "voxels"]


class OutlierRemoval:
    """Removes noise from the voxels of one stream by their neighbourhood in this frame and
    previous ones.

    It works on voxels, not on points: give it to `Decoder.decode` (or to
    `Encoder.encode`, which saves bytes) with every frame of the stream, in order. An
    instance is for one stream.

    Parameters
    ----------
    unit : str
        What the intensities are. "points": counts of depth cameras (law "count"); "faces":
        the laws "quadratic" and "linear"; "voxels": lidars, native intensities, or none;
        "automatic": "faces" from the first frame on that has a depth model, else "voxels".
    min_log_odds : float
        Voxels of lower log-odds of surface against noise are removed; natural logarithm.
        0 removes 79 to 90 % of a depth camera's noise at 4 cm; higher values remove more,
        also of surfaces.
    full_intensity : float
        Intensity of a voxel face that is completely covered, for "faces".
    use_history : bool
        Also use the voxels of previous frames.
    max_blocks : int
        Most blocks of 4 x 4 x 4 voxels to remember, about 270 bytes each.

    Raises
    ------
    ValueError, TypeError
        If a setting is outside its range.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> removal = pcl_ext.OutlierRemoval(unit="points")
    >>> frame = pcl_ext.Encoder(law="count").encode(numpy.random.rand(1000, 3))
    >>> cloud = pcl_ext.Decoder().decode(frame, outliers=removal)
    >>> removal.status.ok
    True
    """

    def __init__(
        self,
        unit: Unit = "automatic",
        *,
        min_log_odds: float = 0.0,
        full_intensity: float = 255.0,
        use_history: bool = True,
        max_blocks: int = 1 << 17,
    ):
        self._native = _native.OutlierRemoval(
            {
                "unit": unit,
                "min_log_odds": min_log_odds,
                "full_intensity": full_intensity,
                "use_history": use_history,
                "max_blocks": max_blocks,
            }
        )

    @property
    def status(self) -> Status:
        """Why voxels of the last frame were not judged, if they were not: all of them stay
        then."""
        code, message, _ = self._native.status()
        return Status(code, message)

    @property
    def removed(self) -> int:
        """Number of voxels that were removed from the last frame."""
        return self._native.status()[2]

    def score(self, decoder: Decoder) -> NDArray[np.float32]:
        """Computes the log-odds of the points that a decoder returned last, in their order,
        instead of removing any.

        Call it once for each decoded frame, in place of ``decode(..., outliers=...)``.

        Parameters
        ----------
        decoder : Decoder
            After its call of `Decoder.decode`.

        Returns
        -------
        numpy.ndarray
            float32, one for each point, in the shape of the cloud: natural logarithm of the
            odds of surface against noise; infinite where none is judged (see `status`), NaN
            where a cloud of rows and columns has no point.
        """
        native = getattr(decoder, "_native", None)
        if not isinstance(native, _native.Decoder):
            raise TypeError(f"decoder is a '{type(decoder).__name__}', not a Decoder")
        return self._native.score(native)

    def reset(self) -> None:
        """Forgets all frames, as at the start of a stream."""
        self._native.reset()
