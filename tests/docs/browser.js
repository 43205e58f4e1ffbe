// SPDX-License-Identifier: MIT OR Apache-2.0
// Opens every page in frames of the given widths, and writes down what a reader would trip over.
const found = [];

function scrolls(element, frame) {
  for (let e = element.parentElement; e && e !== frame.contentDocument.body; e = e.parentElement)
    if (["auto", "scroll", "hidden"].includes(frame.contentWindow.getComputedStyle(e).overflowX)) return true;
  return false;
}

async function look(page, width) {
  const frame = document.createElement("iframe");
  frame.style.width = `${width}px`;
  frame.style.height = "900px";
  document.body.appendChild(frame);
  await new Promise(done => { frame.onload = done; frame.src = page; });
  const inside = frame.contentDocument, images = [...inside.images];
  images.forEach(image => { image.loading = "eager"; });
  await Promise.all(images.map(image => image.complete || new Promise(done => { image.onload = image.onerror = done; })));
  for (const image of images)
    if (!image.naturalWidth) found.push([page, width, `broken image ${image.getAttribute("src")}`]);
  for (const link of inside.querySelectorAll("a[href^='#']"))
    if (link.hash.length > 1 && !inside.getElementById(decodeURIComponent(link.hash.slice(1))))
      found.push([page, width, `broken link ${link.hash}`]);
  if (inside.documentElement.scrollWidth > width + 1) {
    const wide = [...inside.querySelectorAll("article *")].find(
      e => e.getBoundingClientRect().right > width + 1 && e.getBoundingClientRect().width > 0 && !scrolls(e, frame));
    found.push([page, width, `wider than the page: ${wide ? wide.outerHTML.slice(0, 80) : "?"}`]);
  }
  frame.remove();
}

(async () => {
  for (const page of PAGES) for (const width of WIDTHS) await look(page, width);
  const report = document.createElement("pre");
  report.id = "report";
  report.textContent = JSON.stringify(found);
  document.body.appendChild(report);
})();
