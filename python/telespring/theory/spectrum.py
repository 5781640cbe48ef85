"""Characteristic roots of one axis, with a certificate that no rightmost root was missed."""

from telespring._core import Spectrum, certified_roots, characteristic_roots, spectral_abscissa
from telespring._errors import CertificateWarning

__all__ = ["CertificateWarning", "Spectrum", "certified_roots", "characteristic_roots", "spectral_abscissa"]
