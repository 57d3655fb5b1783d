"""graincal schema."""

from __future__ import annotations

import typer


def schema() -> None:
    """Print the JSON schema of a calibration file, by which editors complete and check its keys."""
    import json

    from graincal.campaign.file.schema import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))
