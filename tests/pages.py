"""Reports in tests: invented sections, and pages taken apart."""

from html.parser import HTMLParser

from matplotlib.figure import Figure

from sonarbed.reporting.section import Item, Section

VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """What a page shows and refers to; fails on tags that do not nest."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.links, self.text, self.open = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for name, value in attrs if name in {"src", "href"}]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

    @property
    def words(self):
        return " ".join("".join(self.text).split())


def invented(
    context, *, study="first", rows=3, text='1 < 2 & 3 > 2 | "so"', kind=Section, **fields
):
    """Write and return a section with two items, a picture and a table."""
    there = context.on_study(study)
    figure = Figure(figsize=(1, 1))
    figure.subplots().plot([0, 1])
    picture = there.figure("picture", figure, f"picture of {text}")
    table = there.table("table", ("a|b", "<c>"), [(f"row{i}", i) for i in range(rows)], "numbers")
    section = kind(
        study,
        f"Study {study}",
        (
            Item("Figure 1.1", "the source says", text, (picture,), (table,)),
            Item("Table 1.2", "and also", "we find"),
        ),
        **fields,
    )
    section.save(there.study_folder)
    return section
