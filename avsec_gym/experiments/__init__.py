"""One short module for each family of tables or figures."""
