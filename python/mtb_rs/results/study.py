# SPDX-License-Identifier: MIT OR Apache-2.0
"""What many solves together give: tables and charts, saved under one name."""

from __future__ import annotations

import os
from pathlib import Path
from typing import ClassVar

from ..base.check import warn
from ..base.errors import PictureWarning
from ..base.files import check_folder, drafted
from .savable import Savable
from .saved import class_of, record_files


class Study(Savable):
    """A table or a chart, whose files bear one name: NAME.json and NAME.npz, to be loaded, and exports."""

    #: Usual name of its files, what it is called in messages, and the endings of its exports.
    usual_name: ClassVar[str]
    is_one_picture: ClassVar[bool] = True
    called: ClassVar[str]
    endings: ClassVar[tuple[str, ...]]

    def exports(self) -> tuple[dict[str, bytes], list[str]]:
        """Files for people and other programs by their endings, and what is left out."""
        raise NotImplementedError

    @classmethod
    def wrote(cls, folder: Path, name: str) -> bool:
        """Whether an earlier one wrote the files of this name that have no record."""
        return False

    @classmethod
    def check_saveable(cls, directory: str | Path, name: str | None = None) -> Path:
        """The directory that it is to be saved into; nothing is left there.

        Raises
        ------
        ValueError, OSError
            As :meth:`save`.
        """
        folder = check_folder(directory)
        stem = cls.usual_name if name is None else name
        present = [folder / f"{stem}.{ending}" for ending in (*cls.endings, "npz", "json")]
        present = [path for path in present if os.path.lexists(path)]
        record = folder / f"{stem}.json"
        is_own = class_of(record) == cls.__name__ if os.path.lexists(record) else cls.wrote(folder, stem)
        if present and not is_own:
            raise ValueError(
                f"{present[0]} is there already, and no earlier {cls.called} has written it: it would be "
                "overwritten; move it, or write into another directory"
            )
        return folder

    def save(self, directory: str | Path, name: str | None = None) -> list[Path]:
        """Writes it into a directory, which is made if need be: its data, which :func:`mtb_rs.load` reads
        (NAME.json, NAME.npz), and what it exports.

        Parameters
        ----------
        directory : str or Path
        name : str or None
            Of the files; None: "chart", "sweep", "area_load", "stability", "vibration" or
            "wheelset_geometry".

        Returns
        -------
        list of Path

        Raises
        ------
        ValueError
            If there is nothing to show in it, or if files of these names were written by something else.
        OSError
            If nothing can be written there.

        Warns
        -----
        PictureWarning
            For what is left out because a package is missing.
        """
        folder = self.check_saveable(directory, name)
        stem = self.usual_name if name is None else name
        exported, notices = self.exports()
        files = {f"{stem}.{ending}": content for ending, content in exported.items()}
        files |= record_files(self._kept(), stem)
        with drafted(folder) as draft:
            for file, content in files.items():
                draft.write(file, content)
            for file in files:
                draft.move(file)
        for ending in (*self.endings, "npz"):
            if f"{stem}.{ending}" not in files:
                (folder / f"{stem}.{ending}").unlink(missing_ok=True)
        for notice in notices:
            warn(notice, PictureWarning)
        return [folder / file for file in files]
