"""Results and recordings in the formats of the field: motion-BIDS folders and MATLAB files."""

from telespring.exchange.bids import BidsExport, export_bids
from telespring.exchange.mat_file import export_mat

__all__ = ["BidsExport", "export_bids", "export_mat"]
