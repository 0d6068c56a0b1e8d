from typing import Any, Callable, Optional

def solve(path: str, start: str = ..., max_iterations: int = ..., threads: int = ...,
          callback: Optional[Callable[[dict[str, Any]], Optional[bool]]] = ..., leave_out: bool = ...) -> dict[str, Any]: ...
