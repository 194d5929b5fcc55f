// What axe-core leaves out: words of drawings, sizes of letters, headings without words.
() => {
  const found = [];
  const levels = (text) => text.match(/[\d.]+/g).map(Number);
  const luminance = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((level) => {
      const share = level / 255;
      return share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, other) => {
    const [low, high] = [luminance(one), luminance(other)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const behind = (element) => {
    for (let one = element; one; one = one.parentElement) {
      const colour = levels(getComputedStyle(one).backgroundColor);
      if (colour.length === 3 || colour[3] > 0) return colour;
    }
    return [255, 255, 255];
  };
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const fields = [...document.querySelectorAll("input, select, textarea")];
  const elements = new Set(fields);
  while (words.nextNode()) {
    if (words.currentNode.textContent.trim()) elements.add(words.currentNode.parentElement);
  }
  for (const one of elements) {
    if (["SCRIPT", "STYLE", "OPTION"].includes(one.tagName) || !one.getClientRects().length) continue;
    const style = getComputedStyle(one);
    const drawn = one instanceof SVGElement;
    const matrix = drawn ? one.getScreenCTM() : null;
    const size = parseFloat(style.fontSize) * (drawn ? Math.hypot(matrix.a, matrix.b) : 1);
    const what = `${one.tagName} "${one.textContent.trim().slice(0, 40)}"`;
    if (size < 11.99) found.push(`${size.toFixed(2)} px: ${what}`);
    if (drawn) {
      const ratio = contrast(levels(style.fill), behind(one));
      if (ratio < 4.5) found.push(`contrast ${ratio.toFixed(2)}: ${what}`);
    }
  }
  for (const head of document.querySelectorAll("th")) {
    if (!head.innerText.trim()) found.push(`a heading without words in ${head.closest("table").parentElement.ariaLabel}`);
  }
  return found;
}
