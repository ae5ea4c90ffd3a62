"""What the conformance suites of channels and radios share."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from typing import Any

import pytest

from modelcast import channel


@pytest.fixture(scope="session")
def concrete_classes() -> Callable[[type[Any]], set[type[Any]]]:
    """All classes below a base that modules of `modelcast.channel` define and that can be instantiated."""
    names = [module.name for module in pkgutil.walk_packages(channel.__path__, f"{channel.__name__}.")]
    defined = [
        one
        for module in map(importlib.import_module, names)
        for _, one in inspect.getmembers(module, inspect.isclass)
        if one.__module__ == module.__name__
    ]
    return lambda base: {one for one in defined if issubclass(one, base) and not inspect.isabstract(one)}
