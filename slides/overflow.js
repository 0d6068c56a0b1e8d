// Runs where decks lie in templates; shows one after the other, all its pages at once. On every page: no element leaves the page, the flow ends above the
// footer, no code is cut; and in every figure: no word leaves the figure. Leaves {deck: [pages, found]} in a <pre>.
(async () => {
  const style = document.createElement('style');
  style.textContent = '* { content-visibility: visible !important; } ' +
    '.bespoke-marp-slide, svg[data-marpit-svg] { position: static !important; display: block !important; }';
  document.head.append(style);
  await document.fonts.ready;
  const words = (element) => (element.textContent || element.tagName).trim().replace(/\s+/g, ' ').slice(0, 40);
  const outside = () => {
    const found = [];
    document.querySelectorAll('section').forEach((section, index) => {
      const page = section.getBoundingClientRect(), scale = page.width / 1280;
      const say = (element, what) => {
        element.classList.add('said');  // and its children need not
        found.push(`page ${index + 1}: <${element.tagName.toLowerCase()}> “${words(element)}” ${what}`);
      };
      if (!page.width) { say(section, 'is not shown'); return; }
      const footer = section.querySelector(':scope > footer, :scope > header');
      const floor = footer ? footer.getBoundingClientRect().top : page.bottom;
      for (const element of section.querySelectorAll('*')) {
        if (element.closest('mjx-assistive-mml, footer') || element.parentElement.closest('section svg, .said')) continue;
        const box = element.getBoundingClientRect();
        if (!box.width && !box.height) continue;
        const right = Math.round((box.right - page.right) / scale), left = Math.round((page.left - box.left) / scale);
        const top = Math.round((page.top - box.top) / scale), bottom = Math.round((box.bottom - floor) / scale);
        if (right > 0) say(element, `reaches ${right} px out of the page on the right`);
        else if (left > 0) say(element, `reaches ${left} px out of the page on the left`);
        else if (top > 0) say(element, `reaches ${top} px above the page`);
        else if (bottom > 0) say(element, `reaches ${bottom} px below ${footer ? 'the footer\'s top' : 'the page'}`);
        if (/^(PRE|CODE|TABLE|P|UL)$/.test(element.tagName) && element.scrollWidth > element.clientWidth + 1 && element.clientWidth)
          say(element, `is ${element.scrollWidth - element.clientWidth} px too wide for its box`);
      }
    });
    const shown = new Set();
    for (const image of document.querySelectorAll('section img')) {
      if (shown.has(image.src) || !image.src.startsWith('data:image/svg+xml;base64,')) continue;
      shown.add(image.src);
      const holder = document.createElement('div');
      holder.innerHTML = new TextDecoder().decode(Uint8Array.from(atob(image.src.split(',')[1]), (c) => c.charCodeAt(0)));
      document.body.append(holder);
      const svg = holder.querySelector('svg'), frame = svg.getBoundingClientRect();
      for (const text of svg.querySelectorAll('text')) {
        const box = text.getBoundingClientRect();
        const out = Math.max(frame.left - box.left, box.right - frame.right, frame.top - box.top, box.bottom - frame.bottom);
        if (out > 1) found.push(`figure “${svg.querySelector('title').textContent}”: “${words(text)}” reaches ${Math.round(out)} px out`);
      }
      holder.remove();
    }
    return found;
  };
  const measured = {};
  for (const template of document.querySelectorAll('template')) {
    document.documentElement.lang = template.lang;
    document.body.replaceChildren(template.content);
    await Promise.all([...document.images].map((image) => image.decode()));
    measured[template.id] = [document.querySelectorAll('section').length, outside()];
  }
  const report = document.createElement('pre');
  report.id = 'overflow';
  report.textContent = JSON.stringify(measured);
  document.body.replaceChildren(report);
})();
