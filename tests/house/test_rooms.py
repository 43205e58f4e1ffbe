# SPDX-License-Identifier: MIT OR Apache-2.0
"""The rooms of the package: old names of modules lead to the new places."""

from __future__ import annotations

from importlib import import_module

import pytest

import mtb_rs as mtb
from mtb_rs.moved import PLACES


@pytest.mark.parametrize("old", sorted(PLACES))
def test_old_names_of_modules_lead_to_the_new_ones(old: str) -> None:
    module = import_module(f"mtb_rs.{old}")
    for place in PLACES[old]:
        new = import_module(f"mtb_rs.{place}")
        name = next(n for n, thing in vars(new).items() if getattr(thing, "__module__", "") == new.__name__)
        with pytest.warns(DeprecationWarning, match=f"take {name} from mtb_rs.{place}"):
            assert getattr(module, name) is getattr(new, name)
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        module.nothing  # noqa: B018


def test_rooms_that_took_the_name_of_a_module_have_what_it_had() -> None:
    from mtb_rs import friction, geometry

    assert geometry.Profile is mtb.Profile
    assert friction.Coulomb is mtb.Coulomb
