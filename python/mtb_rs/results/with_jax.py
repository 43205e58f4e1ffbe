# SPDX-License-Identifier: MIT OR Apache-2.0
"""Results as functions of JAX, with their exact derivatives (extra ``jax``)."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.check import shortened
from .derivatives import Differentiable

Array = NDArray[np.float64]


def jax_function(
    solve: Callable[..., Differentiable],
    of: str | Sequence[str],
    by: Mapping[str, str],
    at: Mapping[str, ArrayLike],
) -> Callable[..., Any]:
    """A solve as a function of JAX: of arrays to arrays, with exact derivatives forward and in reverse.

    It is a ``jax.custom_jvp`` round a callback, so that `jax.jit`, `jax.grad`, `jax.jacfwd`, `jax.jacrev` and
    `jax.vmap` (one solve after the other) take it; second derivatives raise a ``NotImplementedError``. It
    needs ``jax.config.update("jax_enable_x64", True)``.

    Parameters
    ----------
    solve : callable
        Returns a result for arrays (NumPy; numbers where `at` has a number) by the names in `by`, for example
        ``lambda gap, friction: contact.step(gap=gap, friction=friction)``.
    of : str or sequence of str
        What the function returns: a name of :meth:`mtb_rs.Result.derivative` that the result has as a number
        or an array, or several; of wheels, rows of wheels and patches.
    by : Mapping of str to str
        Argument of `solve` to the name by which the result is derived: ``{"gap": "gap", "friction":
        "friction_field"}``.
    at : Mapping of str to array
        Arguments at which it is solved once, to learn the shapes.

    Returns
    -------
    callable
        Takes the arguments in the order of `by`, or by name; returns an array, or a tuple of them for several
        `of`.

    Raises
    ------
    ImportError
        Without JAX; it names what to install.
    ValueError
        If JAX computes with single precision, a name is unknown, or arguments are missing.
    """
    try:
        import jax
        import jax.numpy as jnp
    except ImportError as error:
        raise ImportError("jax is missing: pip install 'mtb-rs[jax]'") from error
    if not jax.config.jax_enable_x64:
        raise ValueError(
            "JAX computes with single precision, which derivatives do not survive: "
            'jax.config.update("jax_enable_x64", True) is needed at the start of the program'
        )
    if not callable(solve):
        raise ValueError(f"solve is {shortened(solve)}: a function that returns a result is needed")
    if not isinstance(by, Mapping) or not by or not all(isinstance(name, str) for name in by.values()):
        raise ValueError(
            f"by is {shortened(by)}: a mapping of arguments of solve to names of inputs, such as "
            '{"gap": "gap"}, is needed'
        )
    if not isinstance(at, Mapping):
        raise ValueError(f"at is {shortened(at)}: a mapping of the arguments of by to arrays is needed")
    if set(at) != set(by):
        raise ValueError(f"at has {', '.join(at)}: {', '.join(by)}, the arguments of by, are needed")
    names = (of,) if isinstance(of, str) else tuple(of) if isinstance(of, (list, tuple)) else ()
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(f"of is {shortened(of)}: a name of a number or a field, or several, are needed")
    arguments = tuple(by)
    for argument in arguments:
        # NaN is for what is found, as in poses
        if np.asarray(at[argument]).dtype.kind not in "fiu":
            raise ValueError(f"at[{argument!r}] is {shortened(at[argument])}: real numbers are needed")

    def solved_at(given: Iterable[Any]) -> Differentiable:
        # an argument without axes is a number, as users hand it to scenes and motions
        arrays = (np.asarray(v, dtype=float)[()] for v in given)
        return solve(**dict(zip(arguments, arrays, strict=True)))

    def told(result: Differentiable) -> tuple[Array, ...]:
        return tuple(np.asarray(value_of(result, name), dtype=float) for name in names)

    try:
        inspect.signature(solve).bind(**dict.fromkeys(arguments))
    except (TypeError, ValueError) as error:
        raise ValueError(f"by has {', '.join(arguments)}, and solve cannot be called so: {error}") from None
    first = solved_at(at[name] for name in arguments)
    shapes = tuple(map(np.shape, told(first)))
    inputs = tuple(np.shape(np.asarray(at[name])) for name in arguments)
    for name, own in zip(names, shapes, strict=True):
        for argument, shape in zip(arguments, inputs, strict=True):
            found = np.shape(first.derivative(name, by[argument]))
            needed = found[len(own) :]
            if needed != shape:
                raise ValueError(
                    f"at[{argument!r}] has shape {shape}, but {by[argument]} has the shape {needed} in the "
                    "derivatives: an argument of that shape is needed"
                )

    def values(*given: Any) -> tuple[Array, ...]:
        return told(solved_at(given))

    def jacobians(*given: Any) -> tuple[tuple[Array, ...], tuple[tuple[Array, ...], ...]]:
        result = solved_at(given)
        gradients = [result.gradient(name) for name in names]
        return told(result), tuple(
            tuple(np.asarray(gradient[by[a]], dtype=float) for a in arguments) for gradient in gradients
        )

    def shaped(shape: tuple[int, ...]) -> Any:
        return jax.ShapeDtypeStruct(shape, np.float64)

    of_values = tuple(map(shaped, shapes))
    of_jacobians = tuple(tuple(shaped((*shape, *other)) for other in inputs) for shape in shapes)

    def solved(*given: Any) -> Any:
        return jax.pure_callback(values, of_values, *given, vmap_method="sequential")

    def linearised(*given: Any) -> Any:
        return jax.pure_callback(jacobians, (of_values, of_jacobians), *given, vmap_method="sequential")

    def twice(primals: Any, tangents: Any) -> Any:
        raise NotImplementedError("second derivatives of a solve are not known: jax_function has first ones")

    with_slopes_once: Any = jax.custom_jvp(linearised)
    with_slopes_once.defjvp(twice)

    def derived(primals: Any, tangents: Any) -> Any:
        found, by_all = with_slopes_once(*primals)
        changes = tuple(
            sum(jnp.tensordot(j, t, axes=jnp.ndim(t)) for j, t in zip(row, tangents, strict=True))
            for row in by_all
        )
        return found, changes

    with_slopes: Any = jax.custom_jvp(solved)
    with_slopes.defjvp(derived)

    def function(*given: Any, **named: Any) -> Any:
        if len(given) > len(arguments):
            raise TypeError(f"the function takes {', '.join(arguments)}: it was given {len(given)} arguments")
        taken = dict(zip(arguments, given, strict=False))
        for name in named:
            if name in taken or name not in arguments:
                twice = "twice" if name in taken else "too"
                raise TypeError(f"the function takes {', '.join(arguments)}: it was given {name} {twice}")
        taken |= named
        if missing := [name for name in arguments if name not in taken]:
            raise TypeError(f"the function takes {', '.join(arguments)}: {missing[0]} is missing")
        for name in arguments:
            if jnp.iscomplexobj(taken[name]):
                raise TypeError(f"{name} is complex: real numbers are needed")
        arrays = [jnp.asarray(taken[name], dtype=jnp.float64) for name in arguments]
        for name, array, shape in zip(arguments, arrays, inputs, strict=True):
            if array.shape != shape:
                raise TypeError(f"{name} has shape {array.shape}: {shape}, as in at, is needed")
        found = with_slopes(*arrays)
        return found[0] if isinstance(of, str) else found

    return function


def value_of(result: Differentiable, name: str) -> Any:
    """The number or field of a result that has a name in its derivatives."""
    own = getattr(result, name, None)
    if isinstance(own, Mapping):
        # of each wheel, as its derivative has them
        return np.array(list(own.values()))
    if own is not None:
        return own
    # numbers of each contact patch of wheels; their fields differ in shape
    patches = getattr(result, "patches", ())
    of_patches = [getattr(patch, name.removeprefix("patch_"), None) for patch in patches]
    if of_patches and all(value is not None and np.ndim(value) <= 1 for value in of_patches):
        return np.array(of_patches)
    sums: dict[str, float] = {}
    if hasattr(result, "pressure"):
        pressure, area = np.asarray(result.pressure), np.asarray(result.area)
        force = float((pressure * area).sum())
        sums = {
            "peak_pressure": float(pressure.max()),
            "normal_force": force,
            "mean_pressure": force / float(area[pressure > 0.0].sum()),
        }
    if name not in sums:
        raise ValueError(
            f"of is {name!r}: a {type(result).__name__} does not have this as a number or an array, which a "
            "function of JAX must return"
        )
    return sums[name]
