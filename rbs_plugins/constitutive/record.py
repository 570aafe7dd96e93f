"""Whether the energy of failing bonds can be recorded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rbs_core import BadInput, always
from rbs_plugins.fields import dissipation_density

if TYPE_CHECKING:
    from rbs_plugins.constitutive.bond_force import BondForce


def check_record(force: BondForce, scene: Sequence[BondForce]) -> None:
    """Looks at a force whose failing bonds shall be recorded, if they shall, and at the other forces of the scene.

    Raises:
        BadInput: if the force pauses, if its bonds are searched again, or if another force of its part may see the same
            bond fail.
    """
    if not force.recording:
        return
    if force.when != always:
        raise BadInput(f"{force.label}: the energy of failing bonds can only be recorded in every step")
    if force.host.searched_again:
        raise BadInput(
            f"{force.label}: the energy of failing bonds is not known where bonds are searched again during a run: "
            "leave FractureDissipation out"
        )
    wanted = [end for end in force.ends if force.wants((end, dissipation_density))]
    if len(wanted) < len(force.ends):
        raise BadInput(
            f"{force.label}: the energy of failing bonds belongs to both parts, and only that of '{wanted[0].name}' is "
            "asked for: add FractureDissipation of the other one"
        )
    others = [each for each in scene if each is not force and each.host is force.host]
    if others:
        raise BadInput(
            f"{force.label}: the energy of failing bonds is not known where several forces act on the bonds of one "
            f"part (here also {others[0].label}): leave FractureDissipation out, or put both laws into one"
        )
