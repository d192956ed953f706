"""Reports: tables, pages and files made from results, without further computation."""
