/* Documents as one HTML file that needs no other: pictures are SVG inside it. */
#include "report/document/document.h"
#include "report/document/escape.h"

/* Points: as on a PDF's page, and on a phone, where letters of the wide one would be too small. */
static const double picture_width = 500, narrow_width = 300;

static const char style[] =
    ":root{color-scheme:light dark;--ink:#1a1a1a;--paper:#fff;--soft:#5f5f5f;--line:#ccc;--shade:#f2f2f2}"
    "@media(prefers-color-scheme:dark){:root{--ink:#e8e8e8;--paper:#16181b;--soft:#a8a8a8;--line:#444;--shade:#22262b}}"
    "body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:var(--ink);background:var(--paper);max-width:52rem;"
    "margin:2rem auto;padding:0 1rem}"
    "h1{font-size:1.7rem;margin:0 0 .2rem;overflow-wrap:anywhere}h2{font-size:1.15rem;margin:2rem 0 .5rem}"
    ".about,footer{color:var(--soft);font-size:.85rem}.lead{font-size:1.1rem}"
    ".part{font-size:1.4rem;border-top:2px solid var(--line);margin-top:3rem;padding-top:1rem;overflow-wrap:anywhere}"
    "footer{border-top:1px solid var(--line);margin-top:2rem;padding-top:.5rem;overflow-wrap:anywhere}"
    "table{border-collapse:collapse;font-size:.82rem;margin:.5rem 0 1rem}th,td{text-align:right;padding:.2rem .7rem}"
    "th:first-child,td:first-child{text-align:left}thead th{border-bottom:1px solid var(--ink)}"
    "tbody tr:nth-child(even){background:var(--shade)}.scroll{overflow-x:auto}"
    "dl{display:grid;grid-template-columns:12rem minmax(0,1fr);gap:.2rem .5rem;font-size:.9rem}dt{color:var(--soft)}"
    "dd{margin:0;overflow-wrap:anywhere}"
    ".logo{float:right;width:auto;height:auto;max-height:4rem;max-width:40%;margin:0 0 .5rem 1rem;border-radius:0}"
    "img{width:100%;height:auto;background:#fff;border-radius:4px}"
    "@media(max-width:36rem){body{margin:1rem auto}h1{font-size:1.35rem}dl{grid-template-columns:minmax(0,1fr);gap:0}"
    "dd{margin:0 0 .5rem}th,td{padding:.2rem .4rem}td:first-child{min-width:6rem}}"
    "@media print{:root{--ink:#1a1a1a;--paper:#fff;--soft:#5f5f5f;--line:#ccc;--shade:#f2f2f2}body{margin:0}"
    "h2{break-after:avoid}.part{break-before:page}img{break-inside:avoid}}";

static void add_facts(const km_block *block, km_text *out) {
  km_text_add(out, "<dl>\n");
  for (size_t r = 0; r < block->rows; ++r) {
    km_text_add(out, "<dt>");
    km_html_escape(block->cells[2 * r], out);
    km_text_add(out, "</dt><dd>");
    km_html_escape(block->cells[2 * r + 1], out);
    km_text_add(out, "</dd>\n");
  }
  km_text_add(out, "</dl>\n");
}

static void add_table(const km_block *block, km_text *out) {
  km_text_add(out, "<div class=\"scroll\"><table>\n");
  for (size_t r = 0; r < block->rows; ++r) {
    km_text_add(out, r == 0 ? "<thead><tr>" : r == 1 ? "<tbody>\n<tr>" : "<tr>");
    for (size_t c = 0; c < block->columns; ++c) {
      km_text_add(out, r == 0 ? "<th>" : "<td>");
      km_html_escape(block->cells[r * block->columns + c], out);
      km_text_add(out, r == 0 ? "</th>" : "</td>");
    }
    km_text_add(out, r == 0 ? "</tr></thead>\n" : "</tr>\n");
  }
  km_text_add(out, block->rows > 1 ? "</tbody></table></div>\n" : "</table></div>\n");
}

/* The picture at a width, as an address that holds its bytes. */
static km_status add_address(const km_block *block, double width, km_text *out, km_error *error) {
  km_text svg = {0};
  km_canvas *canvas;
  km_status status = km_canvas_create(KM_PICTURE_SVG, width, block->height, &svg, &canvas, error);
  if (!status) {
    status = block->draw(block->context, canvas, width, block->height, error);
    if (!status)
      status = km_canvas_finish(canvas, error);
    km_canvas_free(canvas);
  }
  km_text_add(out, "data:image/svg+xml;base64,");
  km_text_base64(out, svg.data, svg.size);
  km_text_free(&svg);
  return status;
}

/* As images of their own, so that the names inside two pictures can't meet: a wide one, and a narrow one for phones. */
static km_status add_picture(const km_block *block, km_text *out, km_error *error) {
  km_text_add(out, "<picture><source media=\"(max-width:36rem)\" srcset=\"");
  km_status status = add_address(block, narrow_width, out, error);
  km_text_add(out, "\"><img alt=\"");
  km_html_escape(block->text, out);
  km_text_add(out, "\" src=\"");
  if (!status)
    status = add_address(block, picture_width, out, error);
  km_text_add(out, "\"></picture>\n");
  return status;
}

static km_status add_block(const km_block *block, km_text *out, km_error *error) {
  static const char *const opening[] = {[KM_BLOCK_LEAD] = "<p class=\"lead\">",
                                        [KM_BLOCK_PART] = "<h2 class=\"part\">",
                                        [KM_BLOCK_HEADING] = "<h2>",
                                        [KM_BLOCK_TEXT] = "<p>"};
  bool title = block->kind == KM_BLOCK_HEADING || block->kind == KM_BLOCK_PART;
  switch (block->kind) {
  case KM_BLOCK_LEAD:
  case KM_BLOCK_PART:
  case KM_BLOCK_HEADING:
  case KM_BLOCK_TEXT:
    km_text_add(out, opening[block->kind]);
    km_html_escape(block->text, out);
    km_text_add(out, title ? "</h2>\n" : "</p>\n");
    return KM_OK;
  case KM_BLOCK_FACTS:
    add_facts(block, out);
    return KM_OK;
  case KM_BLOCK_TABLE:
    add_table(block, out);
    return KM_OK;
  case KM_BLOCK_FILM:
    km_film_write(block->film, out);
    return KM_OK;
  default:
    return add_picture(block, out, error);
  }
}

static void add_logo(const km_text *logo, km_text *out) {
  if (!logo || logo->size == 0)
    return;
  km_text_add(out, "<img class=\"logo\" alt=\"logo\" src=\"data:image/png;base64,");
  km_text_base64(out, logo->data, logo->size);
  km_text_add(out, "\">\n");
}

/* The document's film; NULL: none. */
static const km_film_page *film_of(const km_document *document) {
  for (size_t i = 0; i < document->count; ++i)
    if (document->blocks[i].kind == KM_BLOCK_FILM)
      return document->blocks[i].film;
  return NULL;
}

km_status km_document_html(const km_document *document, km_text *out, km_error *error) {
  const km_film_page *film = film_of(document);
  km_status status = KM_OK;
  km_text_add(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
                   "content=\"width=device-width, initial-scale=1\">\n<title>");
  km_html_escape(document->title, out);
  km_text_format(out, "</title>\n<style>%s", style);
  if (film)
    km_film_styles_write(film, out);
  km_text_add(out, "</style>\n</head>\n<body>\n");
  add_logo(document->logo, out);
  km_text_add(out, "<h1>");
  km_html_escape(document->title, out);
  km_text_add(out, "</h1>\n<p class=\"about\">");
  km_html_escape(document->subtitle, out);
  km_text_add(out, "</p>\n");
  for (size_t i = 0; i < document->count && !status; ++i)
    status = add_block(&document->blocks[i], out, error);
  km_text_add(out, "<footer>");
  km_html_escape(document->footer, out);
  km_text_add(out, "</footer>\n");
  if (film)
    km_film_script_write(film, out);
  km_text_add(out, "</body>\n</html>\n");
  return status ? status : out->failed ? km_fail(error, KM_MEMORY, "out of memory for a report") : KM_OK;
}
