"""Arrays that users give, in the form that the engine takes."""

import numpy


def numbers(values, what):
    """As a C-contiguous array of float64."""
    array = numpy.asarray(values)
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{what} must be real numbers, not an array of {array.dtype}")
    return numpy.ascontiguousarray(array, dtype=numpy.float64)


def frames_by_channels(values, what):
    """The same with two axes; one axis is one channel."""
    array = numbers(values, what)
    if array.ndim == 1:
        array = array[:, numpy.newaxis]
    if array.ndim != 2:
        raise ValueError(f"{what} must have the shape (frames, channels), not {array.shape}")
    return array


def one_channel(values, what):
    """The same with one axis."""
    array = numbers(values, what)
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim != 1:
        raise ValueError(f"{what} must have the shape (frames,), not {array.shape}")
    return array
