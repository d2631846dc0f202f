"""Results for other programs (docs/export.md): USD with time samples, VTKHDF, VTU with fields, elements as
VTU, glTF, and series as Parquet and MCAP. Packages that a format needs are those of the extra 'export'."""

from .elements import write_elements
from .exporter import FORMATS, Exporter, export_recording
from .series import write_series

__all__ = ["FORMATS", "Exporter", "export_recording", "write_elements", "write_series"]
