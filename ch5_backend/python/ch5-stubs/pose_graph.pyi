from os import PathLike
from typing import Any, Callable, Optional, Union

def solve(path: Union[str, PathLike[str]], start: Optional[str] = ..., max_iterations: int = ..., threads: int = ...,
          callback: Optional[Callable[[dict[str, Any]], Optional[bool]]] = ..., leave_out: bool = ...) -> dict[str, Any]: ...
