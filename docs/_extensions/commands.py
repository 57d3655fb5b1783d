"""The directive `graincal-commands`: every command of `graincal`, from the descriptions that `--help` prints."""

from collections.abc import Iterator
from typing import Any

import typer
from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx

from graincal.cli import app


class Commands(Directive):
    """A section for each command, with its usage, its description, its arguments and options, and its example."""

    def run(self) -> list[nodes.Node]:
        return [self._section(name, command, context) for name, command, context in _commands()]

    def _section(self, name: str, command: Any, context: Any) -> nodes.section:
        section = nodes.section(ids=[nodes.make_id(name)], names=[nodes.fully_normalize_name(name)])
        section += nodes.title(text=name)
        usage = " ".join([name, *command.collect_usage_pieces(context)])
        section += nodes.literal_block(usage, usage, language="text")
        for paragraph in (command.help or "").split("\n\n"):
            section += nodes.paragraph(text=" ".join(paragraph.split()))
        if options := [option for parameter in command.params if (option := _option(parameter, context))]:
            section += nodes.definition_list("", *options)
        if command.epilog:
            example = command.epilog.removeprefix("Example:").strip()
            section += [nodes.paragraph(text="Example:"), nodes.literal_block(example, example, language="sh")]
        return section


def _commands() -> Iterator[tuple[str, Any, Any]]:
    """Name, command and context of each command that runs something; those of a group follow in its place."""
    group = typer.main.get_command(app)
    yield from _within(group, group.make_context("graincal", [], resilient_parsing=True))


def _within(group: Any, context: Any) -> Iterator[tuple[str, Any, Any]]:
    for name, command in group.commands.items():
        inner = type(context)(command, info_name=name, parent=context)
        if hasattr(command, "commands"):
            yield from _within(command, inner)
        else:
            yield f"{context.command_path} {name}", command, inner


def _option(parameter: Any, context: Any) -> nodes.definition_list_item | None:
    record = parameter.get_help_record(context)
    if record is None:
        return None
    names, said = record
    return nodes.definition_list_item("", nodes.term("", "", nodes.literal(text=names)), nodes.definition("", nodes.paragraph(text=said)))


def setup(sphinx: Sphinx) -> dict[str, bool]:
    sphinx.add_directive("graincal-commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
