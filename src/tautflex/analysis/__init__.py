"""Analysis of responses: spectrum, scalogram, proper orthogonal modes, modal assurance criterion."""

from tautflex.analysis.mac import mac, mac_table
from tautflex.analysis.pod import dominant_shape, pod
from tautflex.analysis.record import Record, UniformRecord, maneuver_end, uniform_record
from tautflex.analysis.spectrum import PeakFrequency, amplitude, dominant_frequency, spectrum
from tautflex.analysis.wavelet import scalogram

__all__ = [
    "PeakFrequency",
    "Record",
    "UniformRecord",
    "amplitude",
    "dominant_frequency",
    "dominant_shape",
    "mac",
    "mac_table",
    "maneuver_end",
    "pod",
    "scalogram",
    "spectrum",
    "uniform_record",
]
