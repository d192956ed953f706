// Scores of the search: pages that explain come before lists of names; each mistake of the kit has a page, and comes last.
var Scorer = {
  score: ([docname, title, anchor, description, score]) => {
    if (/^generated\/mistakes\//.test(docname)) return score - 60;
    if (/^(gallery_pages|project|generated\/(schemes|problems))\b/.test(docname)) return score - 15;
    if (/^(explanation|how-to|tutorial|install)/.test(docname)) return score + 3;
    return score;
  },
  objNameMatch: 11,
  objPartialMatch: 4,
  objPrio: { 0: 8, 1: 3, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
