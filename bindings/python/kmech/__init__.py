"""Mobility, leverage, forces and redundant arms of mechanisms: libkmech for Python.

    import kmech
    model = kmech.load("brake.json")
    model.sweep("K", 20, 32).plot()

Models come from files (the JSON format, URDF, MJCF, SDF), texts or a Builder. Each analysis is a question with options:
Model.mobility, Model.advantage, Model.forces … are made from the library's table of questions. Answers are NumPy
structured arrays over the library's memory. Failures are exceptions that tell the place, what was found and what was
expected. Calls release the GIL: threads work in parallel, each with a state of its own."""
from . import _comments
from ._kmech import ffi, lib
from .arm import Arm, Study, Summary, Track, load_study
from .build import Builder
from .designs import DesignStudy, Statistics, Yield, load_designs
from .diagnosis import JointChange, RemedySet
from .errors import (Cancelled, Diverged, FileError, InternalError, KmechError, Message, ModelError, ModelWarning,
                     NoResult, UsageError, text_of)
from .linear import Linear
from .space import AssemblyModes, SpaceMap
from .mechanism import Mechanism, Mobility, Pose, State
from .model import Model, from_string, load
from .picture import Picture
from .question import Answer, Event, kinds
from .session import Crossing, FrameMotion, PassedLimit, Session
from .table import Table

__version__ = text_of(lib.km_version())


def documentation(function: str) -> str:
    """What the C header says of a function of the library, as "km_model_read"."""
    if function not in _comments.FUNCTIONS:
        raise UsageError(f"\"{function}\" is no function of the library")
    return _comments.FUNCTIONS[function]


__all__ = ["Answer", "Arm", "AssemblyModes", "Builder", "Cancelled", "Crossing", "DesignStudy", "Diverged", "Event", "FileError", "FrameMotion", "InternalError", "JointChange", "KmechError", "Linear",
           "Mechanism", "Message", "Mobility", "Model", "ModelError", "ModelWarning", "NoResult", "PassedLimit", "Picture", "Pose", "RemedySet", "Session",
           "SpaceMap", "State", "Statistics", "Study", "Summary", "Table", "Track", "UsageError", "Yield", "documentation", "ffi", "from_string", "kinds", "lib", "load",
           "load_designs", "load_study"]

# What the C headers say of the functions behind methods stands below each one's own words.
_BEHIND = {
    Model.set_position: "km_model_set_position", Model.set_limits: "km_model_set_limits",
    Model.set_frame: "km_model_set_frame", Model.set_mass: "km_model_set_mass", Model.vary: "km_model_read_varied",
    Model.to_json: "km_model_write", Model.save: "km_model_write_as", Model.limits: "km_model_coordinate_limits", load: "km_model_read_file_as",
    Mechanism.__init__: "km_mechanism_compile_at", Mechanism.renumber: "km_mechanism_renumber",
    Mechanism.new_state: "km_state_create", State.assemble: "km_assemble", State.reach: "km_state_move_to",
    State.mobility: "km_mobility_compute", State.frame: "km_frame_place", State.jacobian: "km_frame_jacobian",
    Arm.__init__: "km_arm_create", Arm.place: "km_arm_place", Arm.jacobian: "km_arm_jacobian", Arm.solve: "km_arm_solve",
    Study.track: "km_track_run", Answer.figure: "km_table_figure", Answer.save_csv: "km_table_write_csv",
    Answer.save_xlsx: "km_question_xlsx", Answer.plot: "km_question_chart", Track.plot: "km_tracks_picture", Builder.body: "km_model_add_body",
    Builder.frame: "km_model_add_frame", Builder.joint: "km_model_add_joint", Builder.couple: "km_model_add_coupling",
    Mechanism.linearise: "km_linearise", Mechanism.equilibrium: "km_equilibrium_find",
    Mechanism.remedies: "km_remedy_set_find", Mechanism.diagnose: "km_diagnosis_find",
    DesignStudy.__init__: "km_design_study_read", DesignStudy.run: "km_design_study_run",
    DesignStudy.ranks: "km_design_study_ranks",
    Session.__init__: "km_session_create", Session.step: "km_session_step",
    Builder.load: "km_model_add_load", Builder.finish: "km_builder_finish",
}
for _method, _function in _BEHIND.items():
    _method.__doc__ = f"{_method.__doc__ or ''}\n\n{_function}: {documentation(_function)}".strip()
del _method, _function
