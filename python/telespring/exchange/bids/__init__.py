"""Motion-BIDS folders: two people recorded together on one clock."""

from telespring.exchange.bids.export import BidsExport, export_bids

__all__ = ["BidsExport", "export_bids"]
