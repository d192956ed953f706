"""Reports: tables and files made of results, nothing computed anew."""
