"""What there is: identifier and title of manoeuvres, methods, causes, diagnosers and suites."""

from __future__ import annotations


def list_manoeuvres() -> dict[str, str]:
    """Form of a manoeuvre's text, with an example -> what the manoeuvre is."""
    from ..datasets.manoeuvres import KINDS

    return {kind.form: kind.description for kind in KINDS.values()}


def list_methods() -> dict[str, str]:
    """Method id -> kind and title of every identification method, those of plug-ins included.

    Raises
    ------
    BadInput : a plug-in cannot be loaded, or two methods have the same id.
    """
    from ..methods.registry import FAMILIES, methods

    families = {f"{prefix}:NAME": title for prefix, (_, _, title) in FAMILIES.items()}
    return {name: f"{cls.kind}: {cls.title}" for name, cls in methods().items()} | families


def list_causes() -> dict[str, str]:
    """Cause id -> physics of every cause: those that a diagnosis tests, and those that a check of records looks for.

    Raises
    ------
    BadInput : a plug-in cannot be loaded.
    """
    from ..diagnosis.causes.registry import all_causes

    return {name: " ".join(cause.physics.split()) for name, cause in all_causes().items()}


def list_diagnosers() -> dict[str, str]:
    """Diagnoser id -> title of every way to diagnose, those of plug-ins included.

    Raises
    ------
    BadInput : a plug-in cannot be loaded, or two diagnosers have the same id.
    """
    from ..diagnosis.registry import diagnosers

    return {name: cls.title for name, cls in diagnosers().items()}


def list_suites() -> dict[str, str]:
    """Suite name -> title of every suite that ships with helmbench."""
    from ..bench.suites import load_suite, suite_names

    return {name: load_suite(name).title for name in suite_names()}
