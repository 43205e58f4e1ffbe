# SPDX-License-Identifier: MIT OR Apache-2.0
"""Who is told how far a study is: a function, a bar on the terminal or in a notebook, or nobody."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Literal

#: Done and all, or the share that is done and what is being done.
Told = Callable[..., None]


@contextmanager
def shares_shown(
    progress: Callable[[float], Any] | Literal[True] | None, words: str
) -> Iterator[Callable[[float], Any]]:
    """What a calculation calls with the share that is done; True is a bar as of :func:`shown`.

    Raises
    ------
    ValueError
        If `progress` is something else.
    ImportError
        As of :func:`shown`.
    """
    if progress is not None and progress is not True and not callable(progress):
        raise ValueError(f"progress is {progress!r}: a function, True (a bar) or None is needed")
    if progress is not True:
        yield progress or (lambda _: None)
        return
    with shown(True, words) as told:
        yield lambda share: told(share, words)


@contextmanager
def shown(progress: Told | Literal[True] | None, words: str) -> Iterator[Told]:
    """What a study calls to tell how far it is: with numbers (done, all), or with (share, words).

    True is a bar with `words` in front, which goes where it is looked at (extra ``notebook``).

    Raises
    ------
    ImportError
        If a bar is asked for, and tqdm is not installed.
    """
    if progress is not True:
        yield progress or (lambda *_: None)
        return
    try:
        from tqdm.auto import tqdm
    except ImportError as error:
        raise ImportError("tqdm is missing: pip install 'mtb-rs[notebook]'") from error
    with tqdm(total=1, desc=words) as bar:

        def told(done: float, second: Any) -> None:
            if isinstance(second, str):
                bar.set_description_str(second, refresh=False)
                bar.n = round(float(done), 2)
            else:
                bar.total, bar.n = second, done
            bar.refresh()

        yield told
