# The compiled module: for this package alone, which says what its parts are.
from typing import Any

def __getattr__(name: str) -> Any: ...
