"""The studio: a design drawn, shaped and judged in a page of the browser."""
