"""The numbers of every step as one table: Parquet for data frames, MCAP for viewers of logs such as
Foxglove. [https://parquet.apache.org, https://mcap.dev]"""

from __future__ import annotations

import json
import math
from os import PathLike
from pathlib import Path
from typing import Any

from stark._core import InvalidArgument
from stark.arguments import given_path
from stark.array_file import write_atomically
from stark.telemetry import Telemetry

_MISSING = "{} needs the package {} of the extra 'export': pip install 'stark-sim[export]'"
_TOPIC = "/stark/step"
_NANOSECONDS = 1e9


def write_series(telemetry: Telemetry, path: str | PathLike[str]) -> Path:
    """Writes all series of a run as .parquet (a column a series, its unit in the metadata of the field) or
    .mcap (a JSON message a step on the topic /stark/step, at the simulated time); returns the file. Raises
    InvalidArgument for other suffixes, ImportError that names the extra of a package that is missing."""
    file = given_path(path, "write_series: path")
    if file.suffix == ".parquet":
        _write_parquet(telemetry, file)
    elif file.suffix == ".mcap":
        _write_mcap(telemetry, file)
    else:
        raise InvalidArgument(f"write_series: path = '{file}': its suffix must be .parquet or .mcap")
    return file


def _write_parquet(telemetry: Telemetry, path: Path) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise ImportError(_MISSING.format("Parquet", "pyarrow")) from error
    names = telemetry.names
    fields = [pyarrow.field(n, pyarrow.float64(), metadata={"unit": telemetry.unit(n)}) for n in names]
    table = pyarrow.table([telemetry[name] for name in names], schema=pyarrow.schema(fields))
    write_atomically(path, lambda file: parquet.write_table(table, file))


def _write_mcap(telemetry: Telemetry, path: Path) -> None:
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise ImportError(_MISSING.format("MCAP", "mcap")) from error
    write_atomically(path, lambda file: _write_messages(Writer(file), telemetry))


def _write_messages(writer: Any, telemetry: Telemetry) -> None:
    names = telemetry.names
    properties = {name: {"type": "number", "description": f"[{telemetry.unit(name)}]"} for name in names}
    schema = json.dumps({"type": "object", "properties": properties}).encode()
    writer.start(profile="", library="stark")
    kind = writer.register_schema(name="stark.Step", encoding="jsonschema", data=schema)
    channel = writer.register_channel(topic=_TOPIC, message_encoding="json", schema_id=kind)
    columns = [telemetry[name] for name in names]
    for row, time in enumerate(telemetry["time"]):
        at = round(_NANOSECONDS * float(time))
        values = zip(names, (float(column[row]) for column in columns), strict=True)
        message = json.dumps({name: value for name, value in values if math.isfinite(value)}).encode()
        writer.add_message(channel_id=channel, log_time=at, publish_time=at, data=message, sequence=row)
    writer.finish()
