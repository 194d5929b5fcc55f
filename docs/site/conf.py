"""Sphinx's settings of the documentation site; `python docs/site` builds it, in its own process."""

from repository import PROJECT, REPOSITORY
from sphinx.ext.napoleon.docstring import GoogleDocstring

project = "avsec-gym"
author = "avsec-gym"
version = release = PROJECT["version"]
copyright = "avsec-gym, MIT licence"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "index"
highlight_language = "text"  # Blocks without a language are commands.

# Pages: Markdown, whose headings are anchors as on a code host.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
myst_links_external_new_tab = False

# API: the code's own docstrings, in Google's form.
default_role = "py:obj"  # `Name` in a docstring leads there, where the name is on the site.
add_module_names = False
toc_object_entries_show_parents = "hide"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
autodoc_inherit_docstrings = False
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False

# The docstring of a property is a sentence; napoleon takes what stands before a colon for a type.
GoogleDocstring._parse_attribute_docstring = GoogleDocstring._consume_to_end  # type: ignore[method-assign]

html_theme = "furo"
html_title = f"avsec-gym {version}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sphinx = False
pygments_style, pygments_dark_style = "default", "github-dark"
html_theme_options = {
    "source_repository": REPOSITORY,
    "footer_icons": [],
    "light_css_variables": {"color-brand-primary": "#0b5fa5", "color-brand-content": "#0b5fa5"},
    "dark_css_variables": {"color-brand-primary": "#7ab8f5", "color-brand-content": "#7ab8f5"},
}
