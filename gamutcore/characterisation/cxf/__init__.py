"""Samples from CxF3 files: the XML within limits, its objects, and their joining.

Only the standard library and NumPy are used, so that every version of Python can read CxF.
"""

from gamutcore.characterisation.cxf.element_tree import looks_like_cxf, looks_like_xml
from gamutcore.characterisation.cxf.samples import cxf_samples

__all__ = ["cxf_samples", "looks_like_cxf", "looks_like_xml"]
