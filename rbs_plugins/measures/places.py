"""Where a measure writes, if it shall not be the usual field."""

from __future__ import annotations

from rbs_core import BadInput, Field


def place_for(label: str, field: Field, usual: Field) -> Field:
    """A field to write into.

    Args:
        label: who asks, for messages.
        field: as given.
        usual: the field that is written if nobody gives another one.

    Raises:
        BadInput: if it has another place, shape or unit than the usual one.
    """
    wanted = (usual.at, usual.shape, usual.unit)
    if not (isinstance(field, Field) and (field.at, field.shape, field.unit) == wanted):
        listed = ", ".join(f'"{each}"' for each in wanted)
        raise BadInput(f'{label}: {field!r} must be a field like {usual.name}: Field("name", {listed}, symbol, doc)')
    return field
