"""The server that agents talk to, by the Model Context Protocol over standard input and output."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from mecanique.errors import InputError, MecaniqueError
from mecanique.serving.tools import TOOLS

if TYPE_CHECKING:
    from mcp.server import MCPServer


_INSTRUCTIONS = (
    "Analytical mechanics: textbook systems, their equations of motion derived and checked. "
    "Formulas are plain text or LaTeX in the letters that `describe` gives; derivatives are q' "
    "and q''. Call `check` before you hand out an equation of motion."
)


def make_server() -> MCPServer:
    """Return the server with its tools."""
    try:
        from mcp.server import MCPServer
    except ImportError:
        raise InputError(
            "the server for agents needs the package mcp; install mecanique[mcp]"
        ) from None
    from mcp.types import ToolAnnotations

    # no tool changes anything, and each gives the same answer again
    kind = ToolAnnotations(read_only_hint=True, idempotent_hint=True, open_world_hint=False)
    server = MCPServer("mecanique", instructions=_INSTRUCTIONS, log_level="ERROR")
    for tool in TOOLS:
        text = inspect.getdoc(tool) or ""
        server.tool(description=text, annotations=kind)(_say_errors(tool))
    return server


def serve() -> None:
    """Serve over standard input and output until the client leaves."""
    make_server().run("stdio")


def _say_errors(tool: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tool whose errors are phrased in the client's terms: what is wrong, what to do."""
    from mcp.server.mcpserver.exceptions import ToolError

    @functools.wraps(tool)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return tool(*args, **kwargs)
        except MecaniqueError as error:
            raise ToolError(str(error)) from None

    return call
